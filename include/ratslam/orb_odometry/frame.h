/// One image as the odometry sees it: pyramid, features with descriptors, a grid to look features up by
/// place, its pose, and which landmarks it observes where.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ratslam/common/stamp.h"
#include "ratslam/orb_odometry/camera_model.h"
#include "ratslam/orb_odometry/feature_extractor.h"
#include "ratslam/orb_odometry/image_pyramid.h"
#include "ratslam/orb_odometry/rigid_transform.h"

namespace ratslam {

using LandmarkId = std::int64_t;
constexpr LandmarkId kNoLandmark = -1;

/// Finds the points near a place: a regular grid of buckets over the undistorted image.
class PointGrid {
 public:
  PointGrid() = default;
  PointGrid(const std::vector<Feature>& features, double cell_size);

  /// Calls visit(index) for each feature in the cells that a square around `centre` touches, in a fixed
  /// order.
  template <class Visit>
  void forEachNear(const Eigen::Vector2d& centre, double radius, Visit&& visit) const {
    const int left = clampColumn(centre.x() - radius);
    const int right = clampColumn(centre.x() + radius);
    const int top = clampRow(centre.y() - radius);
    const int bottom = clampRow(centre.y() + radius);
    for (int row = top; row <= bottom; ++row) {
      const int begin = starts_[static_cast<std::size_t>(row * columns_ + left)];
      const int end = starts_[static_cast<std::size_t>(row * columns_ + right) + 1];
      for (int slot = begin; slot < end; ++slot) visit(indices_[static_cast<std::size_t>(slot)]);
    }
  }

 private:
  int clampColumn(double x) const;
  int clampRow(double y) const;

  double cell_size_ = 1.0;
  Eigen::Vector2d origin_ = Eigen::Vector2d::Zero();
  int columns_ = 1;
  int rows_ = 1;
  std::vector<int> starts_ = {0, 0};  // first slot of each cell; one more than there are cells
  std::vector<int> indices_;
};

/// Where a frame sees a landmark.
struct Observation {
  LandmarkId landmark = kNoLandmark;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted
  double sigma = 1.0;                               ///< expected error relative to that at level 0
  int level = 0;                                    ///< of the pyramid in which it was measured
};

struct Frame {
  Stamp stamp = 0;
  ImagePyramid pyramid;
  std::vector<Feature> features;
  cv::Mat descriptors;  ///< one row of 32 bytes a feature
  PointGrid grid;       ///< over features[i].pixel
  RigidTransform T_camera_world;
  std::vector<Observation> observations;

  const std::uint8_t* descriptor(int feature) const { return descriptors.ptr<std::uint8_t>(feature); }
  Eigen::Vector3d centre() const { return T_camera_world.inverse().translation; }
};

/// A frame without pose and observations. @param grey 8-bit, one channel, of the camera's size.
Frame makeFrame(Stamp stamp, const cv::Mat& grey, const CameraModel& camera,
                const FeatureExtractor& extractor, const ExtractorParams& params);

/// Gives a frame's features and observations the places that another calibration undistorts them to.
void recalibrate(Frame& frame, const CameraModel& from, const CameraModel& to);

}  // namespace ratslam
