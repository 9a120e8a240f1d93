/// One image of the odometry: pyramid, features with descriptors, a grid for finding features by position, the
/// camera's pose, and the observed landmarks.
#pragma once

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "ratslam/camera/camera_model.h"
#include "ratslam/common/stamp.h"
#include "ratslam/vision/feature_extractor.h"
#include "ratslam/vision/image_pyramid.h"
#include "ratslam/vision/rigid_transform.h"

namespace ratslam {

using LandmarkId = std::int64_t;
constexpr LandmarkId kNoLandmark = -1;

/// Finds the features near a position: a regular grid of buckets over the undistorted image.
class PointGrid {
 public:
  struct Point {
    Eigen::Vector2d pixel;  ///< undistorted
    int feature = 0;        ///< index
    int level = 0;          ///< of the pyramid
  };

  PointGrid() = default;
  PointGrid(const std::vector<Feature>& features, double cell_size);
  /// The same grid without some of the features. @param left_out one flag per feature.
  PointGrid without(const std::vector<bool>& left_out) const;

  /// Calls visit(point) for each feature in the cells that a square around `centre` touches, in a fixed
  /// order.
  template <class Visit>
  void forEachNear(const Eigen::Vector2d& centre, double radius, Visit&& visit) const {
    const int left = clampColumn(centre.x() - radius);
    const int right = clampColumn(centre.x() + radius);
    const int bottom = clampRow(centre.y() + radius);
    for (int row = clampRow(centre.y() - radius); row <= bottom; ++row) visitCells(row, left, right, visit);
  }

  /// The same for the cells within `reach` of a line segment.
  template <class Visit>
  void forEachAlong(const Eigen::Vector2d& begin, const Eigen::Vector2d& end, double reach,
                    Visit&& visit) const {
    const int bottom = clampRow(std::max(begin.y(), end.y()) + reach);
    for (int row = clampRow(std::min(begin.y(), end.y()) - reach); row <= bottom; ++row) {
      const auto [from, to] = columnsAlong(row, begin, end, reach);
      visitCells(row, from, to, visit);
    }
  }

 private:
  template <class Visit>
  void visitCells(int row, int left, int right, Visit&& visit) const {
    const int begin = starts_[static_cast<std::size_t>(row * columns_ + left)];
    const int end = starts_[static_cast<std::size_t>(row * columns_ + right) + 1];
    for (int slot = begin; slot < end; ++slot) visit(points_[static_cast<std::size_t>(slot)]);
  }
  std::pair<int, int> columnsAlong(int row, const Eigen::Vector2d& begin, const Eigen::Vector2d& end,
                                   double reach) const;
  int clampColumn(double x) const {
    return static_cast<int>(std::clamp((x - origin_.x()) * cells_per_pixel_, 0.0, columns_ - 1.0));
  }
  int clampRow(double y) const {
    return static_cast<int>(std::clamp((y - origin_.y()) * cells_per_pixel_, 0.0, rows_ - 1.0));
  }

  double cells_per_pixel_ = 1.0;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int columns_ = 1;
  int rows_ = 1;
  std::vector<int> starts_ = {0, 0};  // first slot of each cell; one more than there are cells
  std::vector<Point> points_;         // cell by cell, row by row
};

/// Observation of a landmark in a frame.
struct Observation {
  LandmarkId landmark = kNoLandmark;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted
  double sigma = 1.0;                               ///< expected error relative to that at level 0
  int level = 0;                                    ///< of the pyramid in which it was measured

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("landmark", landmark);
    fields("pixel", pixel);
    fields("sigma", sigma);
    fields("level", level);
  }
};

struct Frame {
  Stamp stamp = 0;
  ImagePyramid pyramid;
  std::vector<Feature> features;
  cv::Mat descriptors;             ///< one row of 32 bytes per feature
  PointGrid grid;                  ///< over features[i].pixel
  bool features_outdated = false;  ///< features[i].pixel still belongs to an earlier calibration
  RigidTransform T_camera_world;
  std::vector<Observation> observations;

  const std::uint8_t* descriptor(int feature) const { return descriptors.ptr<std::uint8_t>(feature); }
  Eigen::Vector3d centre() const { return T_camera_world.inverse().translation; }
};

/// A frame without pose and observations. @param grey 8-bit, one channel, of the camera's size.
Frame makeFrame(Stamp stamp, const cv::Mat& grey, const CameraModel& camera,
                const FeatureExtractor& extractor, const ExtractorParams& params, WorkerPool& workers);

/// Undistorts a frame's observations with another calibration. The features are only marked as outdated, because
/// they are many and mostly not used again: see refreshFeatures.
void recalibrate(Frame& frame, const CameraModel& from, const CameraModel& to);

/// Sets the undistorted positions of a frame's features. @param pixels one per feature.
void placeFeatures(Frame& frame, const std::vector<Eigen::Vector2d>& pixels);

/// Undistorts a frame's features again if they are outdated.
void refreshFeatures(Frame& frame, const CameraModel& camera);

}  // namespace ratslam
