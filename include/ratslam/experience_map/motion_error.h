/// Covariance of an accumulated motion.
///
/// The errors of the steps are independent. The covariance carries each to the end of the motion.
/// The error of the unit of length has one of three models:
///  - anchored: an Ornstein-Uhlenbeck process about the true unit. With the standard deviation a of the anchor
///    and the walk w over one metre, its correlation length is 2 a^2 / w^2 metres;
///  - not anchored: a random walk;
///  - nothing stated: the unit is the metre.
#pragma once

#include <Eigen/Core>

#include "ratslam/odometry/odometry.h"

namespace ratslam {

struct MotionError {
  /// Of (x, y, z, yaw) in the axes of the start, from the steps whose source states it [odometry's unit, rad].
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  double length = 0.0;          ///< of the whole path, in the odometry's unit, as the two lengths below
  double said_length = 0.0;     ///< of the steps whose source states a covariance
  double scale_kept = 1.0;      ///< factor from the log-scale's error at the start to its part at the end
  double scale_variance = 0.0;  ///< variance that the steps have added to the log-scale
  /// Of the steps whose source states the error of its unit, or whose error no longer matters.
  double said_scale_length = 0.0;

  /// @param cos_yaw, sin_yaw  of the heading at the end of the step, in the axes of the start
  /// @param way  length of the step, in the odometry's unit
  void add(const OdometryStep& step, double cos_yaw, double sin_yaw, double way);

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("covariance", covariance);
    fields("length", length);
    fields("said_length", said_length);
    fields("scale_kept", scale_kept);
    fields("scale_variance", scale_variance);
    fields("said_scale_length", said_scale_length);
  }
};

}  // namespace ratslam
