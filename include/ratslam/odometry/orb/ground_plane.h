/// The road plane ahead of the camera, from two or three images and the motion between them.
///
/// A plane n.X = h in the camera's axes (X forward z, down y; n unit, pointing down) carries a pixel's
/// bearing b into another view as R b + t (n.b)/h. The plane is fitted by aligning the grey values of the
/// patch of road in the present lane: Gauss-Newton over log h and the two tilts of n, coarse to fine, with
/// gain and offset of brightness taken out and residuals weighted robustly; tilt has a prior, because a
/// vehicle's axles allow little. The height comes out in the odometry's own unit: that is what the scale is
/// held by.
///
/// Lucas and Kanade (1981) on a plane-induced homography (Hartley and Zisserman, ch. 13).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ratslam/vision/frame.h"

namespace ratslam {

struct RoadPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< camera axes, unit, towards the ground
  double height = 1.0;                                ///< of the camera above the plane [odometry unit]
};

struct RoadMeasurement {
  RoadPlane plane;
  double sigma_log = 0.0;    ///< standard deviation of log height
  double correlation = 0.0;  ///< of the aligned grey values in [-1, 1]
};

struct RoadParams {
  double nearest = 3.0;         ///< where the patch of road begins [camera heights ahead]
  double farthest = 9.0;        ///< where it ends
  double half_width = 1.1;      ///< to either side: the present lane
  double tilt_sigma_deg = 0.7;  ///< of the prior of the normal, about x (pitch) and z (roll)
  double min_correlation = 0.6;
  double max_sigma_log = 0.1;
};

/// Fits the plane. @param earlier frames that saw the same piece of road, poses relative to `now` known.
/// @param predicted where the plane should be; its normal is the prior of the tilt.
/// @return nothing where the image does not show a well-textured plane there.
std::optional<RoadMeasurement> measureRoad(const CameraModel& camera, const Frame& now,
                                           const std::vector<const Frame*>& earlier,
                                           const RoadPlane& predicted, const RoadParams& params);

/// The same without any idea of the height: tries heights from `lowest` to `highest` first.
std::optional<RoadMeasurement> searchRoad(const CameraModel& camera, const Frame& now,
                                          const std::vector<const Frame*>& earlier,
                                          const Eigen::Vector3d& normal, double lowest, double highest,
                                          const RoadParams& params);

}  // namespace ratslam
