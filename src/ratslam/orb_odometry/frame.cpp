#include "ratslam/orb_odometry/frame.h"

#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

constexpr double kGridCell = 24.0;  // [px]

}  // namespace

PointGrid::PointGrid(const std::vector<Feature>& features, double cell_size) : cell_size_(cell_size) {
  if (features.empty()) return;
  Eigen::Vector2d low = features.front().pixel;
  Eigen::Vector2d high = low;
  for (const Feature& feature : features) {
    low = low.cwiseMin(feature.pixel);
    high = high.cwiseMax(feature.pixel);
  }
  origin_ = low;
  // Wide lenses can throw single points very far out: the outermost cells then hold all that lies beyond
  // them.
  constexpr double kMostCells = 512.0;
  columns_ = 1 + static_cast<int>(std::min(kMostCells, (high.x() - low.x()) / cell_size_));
  rows_ = 1 + static_cast<int>(std::min(kMostCells, (high.y() - low.y()) / cell_size_));

  const auto cell_of = [&](const Feature& feature) {
    return static_cast<std::size_t>(clampRow(feature.pixel.y()) * columns_ + clampColumn(feature.pixel.x()));
  };
  starts_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
  for (const Feature& feature : features) ++starts_[cell_of(feature) + 1];
  for (std::size_t cell = 1; cell < starts_.size(); ++cell) starts_[cell] += starts_[cell - 1];
  std::vector<int> next(starts_.begin(), starts_.end() - 1);
  indices_.resize(features.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    indices_[static_cast<std::size_t>(next[cell_of(features[i])]++)] = static_cast<int>(i);
  }
}

int PointGrid::clampColumn(double x) const {
  return static_cast<int>(std::clamp((x - origin_.x()) / cell_size_, 0.0, columns_ - 1.0));
}

int PointGrid::clampRow(double y) const {
  return static_cast<int>(std::clamp((y - origin_.y()) / cell_size_, 0.0, rows_ - 1.0));
}

Frame makeFrame(Stamp stamp, const cv::Mat& grey, const CameraModel& camera,
                const FeatureExtractor& extractor, const ExtractorParams& params) {
  Frame frame;
  frame.stamp = stamp;
  frame.pyramid = ImagePyramid(grey, params.levels, params.scale_factor);
  frame.features = extractor.extract(frame.pyramid, frame.descriptors);
  if (camera.model != LensModel::kNone) {
    for (Feature& feature : frame.features) feature.pixel = camera.undistort(feature.raw);
  }
  frame.grid = PointGrid(frame.features, kGridCell);
  return frame;
}

void recalibrate(Frame& frame, const CameraModel& from, const CameraModel& to) {
  for (Feature& feature : frame.features) feature.pixel = to.undistort(feature.raw);
  frame.grid = PointGrid(frame.features, kGridCell);
  for (Observation& observation : frame.observations)
    observation.pixel = to.undistort(from.distort(observation.pixel));
}

}  // namespace ratslam
