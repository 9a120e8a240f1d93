/// What an odometry says of its own uncertainty, as the map uses it.
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "ratslam/odometry/odometry.h"

namespace ratslam {

/// Why a covariance cannot be used: a value that is not finite, a negative variance, no symmetry, a variance of
/// the forward speed or the yaw rate that no odometry has. Empty where it can.
std::string whyAbsurd(const TwistCovariance& covariance);

/// Attitude but for the yaw: the rotation that is left of a pose once its heading is taken out on the left.
Eigen::Quaterniond tiltOf(const Eigen::Isometry3d& pose);

/// Covariance of the motion over `dt` seconds whose twist has this covariance, in level axes with x forward.
/// An axis beside the direction of travel whose variance says "unknown" (as odometries in the plane fill it)
/// is taken to be held by the plane.
/// @param tilt  of base_link
StepCovariance stepCovariance(const TwistCovariance& covariance, const Eigen::Quaterniond& tilt, double dt);

}  // namespace ratslam
