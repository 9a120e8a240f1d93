/// How wrong an accumulated motion may be.
///
/// Errors of steps are independent; each is carried to the end of the motion through the turns that follow it.
/// The unit of length: an anchored one wanders about the true one without ever leaving it (an Ornstein-
/// Uhlenbeck process: with the deviation a of the anchor and the walk w over one metre it forgets over
/// 2 a^2 / w^2 metres), one that is not anchored walks freely, and one of which neither is known is metric.
#pragma once

#include <Eigen/Core>

#include "ratslam/odometry/odometry.h"

namespace ratslam {

struct MotionError {
  /// Of (x, y, z, yaw) in the axes of the start, as far as the source says it [odometry's unit, rad].
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  double length = 0.0;          ///< all of the way
  double said_length = 0.0;     ///< way whose error the source says
  double scale_kept = 1.0;      ///< share of the log-scale's deviation at the start that is left at the end
  double scale_variance = 0.0;  ///< of what has come to it on the way, as far as the source says it
  double said_scale_length =
      0.0;  ///< way of whose unit the source says something, or which no longer matters

  /// @param cos_yaw, sin_yaw  of the heading at the end of the step, in the axes of the start
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
