/// A relative pose with covariance, and the operations on such poses: composition, inverse, mean.
///
/// Covariances are of (x, y, z, yaw) in the axes in which the pose is given, to first order (Smith, Self &
/// Cheeseman, "Estimating uncertain spatial relationships in robotics", 1990).
#pragma once

#include <Eigen/Core>

#include "ratslam/experience_map/map_pose.h"

namespace ratslam {

struct UncertainPose {
  RelativePose pose;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("pose", pose);
    fields("covariance", covariance);
  }
};

/// Turns (x, y) of (x, y, z, yaw) by an angle [rad]; z and yaw stay as they are.
Eigen::Matrix4d turnedAxes(double yaw);

/// Composition: `a`, then `b`, which is given in the axes at the end of `a`. Their errors are independent.
UncertainPose joined(const UncertainPose& a, const UncertainPose& b);

/// Inverse: the start in the axes of the end.
UncertainPose inverted(const UncertainPose& a);

/// Mean of two independent measurements of the same pose, weighted by their information.
UncertainPose combined(const UncertainPose& a, const UncertainPose& b);

}  // namespace ratslam
