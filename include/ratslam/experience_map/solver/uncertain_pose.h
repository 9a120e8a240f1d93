/// A pose relative to another one with what is not known of it, and how such poses are joined.
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

/// First `a`, then `b`, which is given in the axes of where `a` ends. Their errors are independent.
UncertainPose joined(const UncertainPose& a, const UncertainPose& b);

/// Where the start is, seen from the end.
UncertainPose inverted(const UncertainPose& a);

/// What is left once one is known as well as the other says, both being of the same pose: weighted by what they
/// know.
UncertainPose combined(const UncertainPose& a, const UncertainPose& b);

}  // namespace ratslam
