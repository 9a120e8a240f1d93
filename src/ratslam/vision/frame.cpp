#include "ratslam/vision/frame.h"

#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

constexpr double kGridCell = 24.0;  // [px]

}  // namespace

PointGrid::PointGrid(const std::vector<Feature>& features, double cell_size)
    : cells_per_pixel_(1.0 / cell_size) {
  if (features.empty()) return;
  Eigen::Vector2d low = features.front().pixel;
  Eigen::Vector2d high = low;
  for (const Feature& feature : features) {
    low = low.cwiseMin(feature.pixel);
    high = high.cwiseMax(feature.pixel);
  }
  origin_ = low;
  // A wide lens can undistort single points to very far away. The outermost cells hold all points beyond them.
  constexpr double kMostCells = 512.0;
  columns_ = 1 + static_cast<int>(std::min(kMostCells, (high.x() - low.x()) / cell_size));
  rows_ = 1 + static_cast<int>(std::min(kMostCells, (high.y() - low.y()) / cell_size));

  const auto cell_of = [&](const Feature& feature) {
    return static_cast<std::size_t>(clampRow(feature.pixel.y()) * columns_ + clampColumn(feature.pixel.x()));
  };
  starts_.assign(static_cast<std::size_t>(columns_ * rows_) + 1, 0);
  for (const Feature& feature : features) ++starts_[cell_of(feature) + 1];
  for (std::size_t cell = 1; cell < starts_.size(); ++cell) starts_[cell] += starts_[cell - 1];
  std::vector<int> next(starts_.begin(), starts_.end() - 1);
  points_.resize(features.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    points_[static_cast<std::size_t>(next[cell_of(features[i])]++)] = {features[i].pixel, static_cast<int>(i),
                                                                       features[i].level};
  }
}

PointGrid PointGrid::without(const std::vector<bool>& left_out) const {
  PointGrid rest = *this;
  rest.points_.clear();
  for (std::size_t cell = 0; cell + 1 < starts_.size(); ++cell) {
    rest.starts_[cell] = static_cast<int>(rest.points_.size());
    for (int slot = starts_[cell]; slot < starts_[cell + 1]; ++slot) {
      const Point& point = points_[static_cast<std::size_t>(slot)];
      if (!left_out[static_cast<std::size_t>(point.feature)]) rest.points_.push_back(point);
    }
  }
  if (!rest.starts_.empty()) rest.starts_.back() = static_cast<int>(rest.points_.size());
  return rest;
}

std::pair<int, int> PointGrid::columnsAlong(int row, const Eigen::Vector2d& begin, const Eigen::Vector2d& end,
                                            double reach) const {
  // Part of the segment near the row's points. The outermost rows extend without end.
  const double top = row == 0 ? -1e9 : origin_.y() + row / cells_per_pixel_ - reach;
  const double bottom = row == rows_ - 1 ? 1e9 : origin_.y() + (row + 1) / cells_per_pixel_ + reach;
  const Eigen::Vector2d step = end - begin;
  double first = 0.0;
  double last = 1.0;
  if (std::abs(step.y()) > 1e-9) {
    const double at_top = (top - begin.y()) / step.y();
    const double at_bottom = (bottom - begin.y()) / step.y();
    first = std::clamp(std::min(at_top, at_bottom), 0.0, 1.0);
    last = std::clamp(std::max(at_top, at_bottom), 0.0, 1.0);
  }
  const double from = begin.x() + first * step.x();
  const double to = begin.x() + last * step.x();
  return {clampColumn(std::min(from, to) - reach), clampColumn(std::max(from, to) + reach)};
}

Frame makeFrame(Stamp stamp, const cv::Mat& grey, const CameraModel& camera,
                const FeatureExtractor& extractor, const ExtractorParams& params, WorkerPool& workers) {
  Frame frame;
  frame.stamp = stamp;
  frame.pyramid = ImagePyramid(grey, params.levels, params.scale_factor);
  frame.features = extractor.extract(frame.pyramid, frame.descriptors, workers);
  if (camera.model != LensModel::kNone) {
    for (Feature& feature : frame.features) feature.pixel = camera.undistort(feature.raw);
  }
  frame.grid = PointGrid(frame.features, kGridCell);
  return frame;
}

void recalibrate(Frame& frame, const CameraModel& from, const CameraModel& to) {
  frame.features_outdated = true;
  for (Observation& observation : frame.observations)
    observation.pixel = to.undistort(from.distort(observation.pixel), observation.pixel);
}

void placeFeatures(Frame& frame, const std::vector<Eigen::Vector2d>& pixels) {
  for (std::size_t i = 0; i < frame.features.size(); ++i) frame.features[i].pixel = pixels[i];
  frame.grid = PointGrid(frame.features, kGridCell);
}

void refreshFeatures(Frame& frame, const CameraModel& camera) {
  if (!frame.features_outdated) return;
  for (Feature& feature : frame.features) feature.pixel = camera.undistort(feature.raw, feature.pixel);
  frame.grid = PointGrid(frame.features, kGridCell);
  frame.features_outdated = false;
}

}  // namespace ratslam
