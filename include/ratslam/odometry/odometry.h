/// What an odometry says, and the motion made of it.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "ratslam/common/stamp.h"

namespace ratslam {

/// One odometry message. The twist holds for the time since the message before it.
struct OdometrySample {
  Stamp stamp = 0;
  double speed = 0.0;     ///< forward [m/s]
  double yaw_rate = 0.0;  ///< [rad/s], counter-clockwise positive
  /// Pose of base_link in the odometry's own frame (x forward at the start, z up), where the source gives
  /// one.
  std::optional<Eigen::Isometry3d> pose;
};

/// A sample as it is after a message has carried it, which rounds the pose's rotation to a quaternion.
/// Whoever hands samples on without a message applies this, so that both ways give the same bits.
inline OdometrySample asTransmitted(OdometrySample sample) {
  if (sample.pose) {
    sample.pose->linear() = Eigen::Quaterniond(sample.pose->linear()).normalized().toRotationMatrix();
  }
  return sample;
}

/// Motion over one stretch of time, in the axes of the robot *at the end* of it (the heading turns first,
/// then the robot moves along it: MODEL's reference arithmetic). A planar odometry has left = up = 0.
struct OdometryStep {
  double dt = 0.0;        ///< [s]
  double rotation = 0.0;  ///< change of heading [rad]
  double forward = 0.0;   ///< [m], negative when reversing
  double left = 0.0;      ///< [m]
  double up = 0.0;        ///< [m]
};

}  // namespace ratslam
