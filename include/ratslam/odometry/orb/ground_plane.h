/// The road plane ahead of the camera, from two or three images and the motion between them.
///
/// Let the plane be n.X = h in the camera's axes (z forward, y down; n is a unit vector that points down). It maps
/// the bearing b of a pixel into another view as R b + t (n.b)/h. The fit aligns the grey values of a patch of road
/// in the present lane, which bends as the way to here does, by Gauss-Newton over log h and the two tilts of n, from
/// coarse to fine. It removes gain and offset of brightness and weights residuals robustly. The tilt has a prior,
/// because a vehicle's suspension allows little. The result is the height in the odometry's own unit, from which the
/// scale follows.
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
  double sigma_log = 0.0;  ///< standard deviation of log height
  /// The point of the patch whose distance from the camera's path is known best, camera axes [odometry unit].
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  /// Standard deviation of log height at the centre, where the tilt does not matter.
  double sigma_centre = 0.0;
  double correlation = 0.0;  ///< of the aligned grey values in [-1, 1]
};

struct RoadParams {
  double nearest = 3.0;         ///< begin of the patch of road [camera heights ahead]
  double farthest = 9.0;        ///< end of the patch [camera heights ahead]
  double half_width = 1.1;      ///< of the patch: the present lane [camera heights]
  double tilt_sigma_deg = 0.7;  ///< prior of the normal, about x (pitch) and z (roll)
  double min_correlation = 0.6;
  double max_sigma_log = 0.1;
};

/// Fits the plane. @param earlier frames that saw the same piece of road, with known poses relative to `now`.
/// @param predicted the expected plane; its normal is the prior of the tilt.
/// @return none if the image does not show a well-textured plane there.
std::optional<RoadMeasurement> measureRoad(const CameraModel& camera, const Frame& now,
                                           const std::vector<const Frame*>& earlier,
                                           const RoadPlane& predicted, const RoadParams& params);

/// The same with an unknown height: first tries heights from `lowest` to `highest`.
std::optional<RoadMeasurement> searchRoad(const CameraModel& camera, const Frame& now,
                                          const std::vector<const Frame*>& earlier,
                                          const Eigen::Vector3d& normal, double lowest, double highest,
                                          const RoadParams& params);

}  // namespace ratslam
