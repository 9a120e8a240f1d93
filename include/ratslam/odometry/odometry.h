/// Samples of an odometry with their uncertainty, and the steps of motion computed from them.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "ratslam/common/stamp.h"

namespace ratslam {

/// Covariance of a twist (vx, vy, vz, wx, wy, wz) in base_link [m/s, rad/s], as in nav_msgs/Odometry.
using TwistCovariance = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

/// Uncertainty of an odometry's unit of length.
struct UnitOfLength {
  /// Relative standard deviation about the true unit, if it is bounded because a road plane, wheels or stereo
  /// anchor the unit. None: the unit is not anchored.
  std::optional<double> anchor_sigma;
  /// Relative standard deviation of the unit's random walk over one metre driven [1/sqrt(m)].
  double walk_sigma = 0.0;
  /// Relative standard deviation of the true unit itself about the metre: one error for all motions, such as that of
  /// a camera height measured by hand. It changes the size of a map and not its shape.
  double constant_sigma = 0.0;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("anchor_sigma", anchor_sigma);
    fields("walk_sigma", walk_sigma);
    fields("constant_sigma", constant_sigma);
  }
};

struct StampedMotion {
  Stamp stamp = 0;
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("stamp", stamp);
    fields("motion", motion);
  }
};

/// Total motion over a stretch whose samples were predicted. The odometry knows it once it measures again. It
/// replaces the motion of the samples of that stretch.
struct OdometryCorrection {
  Stamp from = 0;  ///< stamp of the last measured sample before the stretch
  Stamp to = 0;    ///< stamp of the first measured sample after it
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();  ///< base_link at `to` in base_link at `from`
  /// Of the motion (x, y, z, rx, ry, rz), in the axes of base_link at `from` [m^2, rad^2].
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> covariance =
      Eigen::Matrix<double, 6, 6, Eigen::RowMajor>::Zero();
  /// Poses of base_link at the samples in between, in base_link at `from`, oldest first. Empty: unknown; the
  /// stretch keeps the shape of its samples.
  std::vector<StampedMotion> way;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("from", from);
    fields("to", to);
    fields("motion", motion);
    fields("covariance", covariance);
    // As lists of plain values they fit into the rows of a table.
    std::vector<Stamp> stamps;
    std::vector<Eigen::Isometry3d> motions;
    for (const StampedMotion& moved : way) {
      stamps.push_back(moved.stamp);
      motions.push_back(moved.motion);
    }
    fields("way_stamps", stamps);
    fields("way_motions", motions);
    way.clear();
    for (std::size_t i = 0; i < stamps.size(); ++i) way.push_back({stamps[i], motions[i]});
  }
};

/// One sample of an odometry. The twist holds for the time since the sample before it.
struct OdometrySample {
  Stamp stamp = 0;
  double speed = 0.0;     ///< forward [m/s]
  double yaw_rate = 0.0;  ///< [rad/s], counter-clockwise positive
  /// Pose of base_link in the odometry's own frame (x forward at the start, z up); none if the source has none.
  std::optional<Eigen::Isometry3d> pose;
  /// Of the mean twist since the sample before; none: unknown, defaults apply.
  std::optional<TwistCovariance> covariance;
  /// None: unknown, defaults apply.
  std::optional<UnitOfLength> unit;
  /// Changes when the source starts anew: poses of different epochs cannot be compared.
  std::uint32_t epoch = 0;
  /// The motion was predicted, not measured, because tracking was lost or the image showed nothing.
  bool bridged = false;
  std::optional<OdometryCorrection> correction;
  /// To the left [m/s]. It is not used and not saved: only a warning depends on it (odometry_doubts.h).
  double sideways = 0.0;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("stamp", stamp);
    fields("speed", speed);
    fields("yaw_rate", yaw_rate);
    fields("pose", pose);
    fields("covariance", covariance);
    fields("unit", unit);
    fields("epoch", epoch);
    fields("bridged", bridged);
    fields("correction", correction);
  }
};

/// The sample as it would arrive in a message, which rounds the pose's rotation to a quaternion. Code that hands
/// on samples without a message calls this, so that nodes and offline runner get the same bits.
inline OdometrySample asTransmitted(OdometrySample sample) {
  const auto rounded = [](Eigen::Isometry3d& pose) {
    pose.linear() = Eigen::Quaterniond(pose.linear()).normalized().toRotationMatrix();
  };
  if (sample.pose) rounded(*sample.pose);
  if (sample.correction) {
    rounded(sample.correction->motion);
    for (StampedMotion& between : sample.correction->way) rounded(between.motion);
  }
  return sample;
}

/// Covariance of a step (forward, left, up, rotation) in its axes [m^2, rad^2].
using StepCovariance = Eigen::Matrix4d;

/// Motion over one stretch of time, in the axes of the robot *at the end* of it: first the heading turns, then the
/// robot moves (the reference arithmetic of docs/model.md). A planar odometry has left = up = 0.
struct OdometryStep {
  double dt = 0.0;        ///< [s]
  double rotation = 0.0;  ///< change of heading [rad]
  double forward = 0.0;   ///< [m], negative when reversing
  double left = 0.0;      ///< [m]
  double up = 0.0;        ///< [m]
  /// None: unknown.
  std::optional<StepCovariance> covariance;
  std::optional<UnitOfLength> unit;
  bool new_unit = false;  ///< the unit of length begins anew with this step
  bool bridged = false;   ///< predicted, not measured
  /// Attitude at the end without the yaw (odometry/uncertainty.h).
  Eigen::Quaterniond tilt = Eigen::Quaterniond::Identity();

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("covariance", covariance);
    fields("unit", unit);
    fields("new_unit", new_unit);
    fields("bridged", bridged);
    fields("tilt", tilt);
    fields("dt", dt);
    fields("rotation", rotation);
    fields("forward", forward);
    fields("left", left);
    fields("up", up);
  }
};

}  // namespace ratslam
