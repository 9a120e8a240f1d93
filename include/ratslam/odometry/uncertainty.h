/// Uncertainty of an odometry: checks of its covariances, and their conversion to that of a step.
#pragma once

#include <Eigen/Geometry>
#include <string>

#include "ratslam/odometry/odometry.h"

namespace ratslam {

/// Why a covariance cannot be used: a value is not finite, a variance is negative, the matrix is not symmetric, or
/// the variance of forward speed or yaw rate is 10^4 or more [m^2/s^2, rad^2/s^2], or an entry exceeds what its
/// variances allow. Empty if it can be used.
std::string whyAbsurd(const TwistCovariance& covariance);

/// The covariance, made smaller as a whole if a variance is larger than can be used. An odometry that knows nothing of its
/// speed may compute such a variance.
TwistCovariance bounded(const TwistCovariance& covariance);

/// Heading of a pose.
double yawOf(const Eigen::Isometry3d& pose);

/// Attitude without the yaw: the rotation that remains of a pose when its heading is removed on the left.
Eigen::Quaterniond tiltOf(const Eigen::Isometry3d& pose);

/// Covariance of the motion over `dt` seconds, in level axes with x forward. A planar odometry often gives the
/// axes across the direction of travel a variance that means "unknown". The plane is taken to constrain them.
/// @param covariance  of the twist  @param tilt  of base_link
StepCovariance stepCovariance(const TwistCovariance& covariance, const Eigen::Quaterniond& tilt, double dt);

}  // namespace ratslam
