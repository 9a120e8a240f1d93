/// What an odometry says, how well it knows it, and the motion made of it.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "ratslam/common/stamp.h"

namespace ratslam {

/// Covariance of a twist (vx, vy, vz, wx, wy, wz) in base_link [m/s, rad/s], as nav_msgs/Odometry has it.
using TwistCovariance = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

/// How well an odometry knows its unit of length.
struct UnitOfLength {
  /// Relative standard deviation about the true unit that does not grow: what road, wheel or stereo leave.
  /// None: the unit is not anchored to anything.
  std::optional<double> anchor_sigma;
  /// Relative standard deviation of the unit's random walk over one metre driven [1/sqrt(m)].
  double walk_sigma = 0.0;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("anchor_sigma", anchor_sigma);
    fields("walk_sigma", walk_sigma);
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

/// Total motion over a stretch whose samples were predictions, known once the odometry measures again. It
/// takes the place of what the samples of that stretch said.
struct OdometryCorrection {
  Stamp from = 0;  ///< stamp of the last measured sample before the stretch
  Stamp to = 0;    ///< stamp of the first measured sample after it
  Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();  ///< base_link at `to` in base_link at `from`
  /// Of the motion (x, y, z, rx, ry, rz), in the axes of base_link at `from` [m^2, rad^2].
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> covariance =
      Eigen::Matrix<double, 6, 6, Eigen::RowMajor>::Zero();
  /// Where base_link was at the samples in between, in base_link at `from`, oldest first; empty: the source
  /// does not say, and the stretch keeps the course that its samples had.
  std::vector<StampedMotion> way;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("from", from);
    fields("to", to);
    fields("motion", motion);
    fields("covariance", covariance);
    // Lists of plain values, which fit into the rows of a table.
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

/// One odometry message. The twist holds for the time since the message before it.
struct OdometrySample {
  Stamp stamp = 0;
  double speed = 0.0;     ///< forward [m/s]
  double yaw_rate = 0.0;  ///< [rad/s], counter-clockwise positive
  /// Pose of base_link in the odometry's own frame (x forward at the start, z up), where the source gives
  /// one.
  std::optional<Eigen::Isometry3d> pose;
  /// Of the twist over the time since the sample before; none: the source does not say, defaults apply.
  std::optional<TwistCovariance> covariance;
  /// None: the source does not say, defaults apply.
  std::optional<UnitOfLength> unit;
  /// Changes when the source starts anew: its pose then has nothing to do with the poses before.
  std::uint32_t epoch = 0;
  /// The motion was predicted, not measured: tracking was lost or there was nothing to see.
  bool bridged = false;
  std::optional<OdometryCorrection> correction;

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

/// A sample as it is after a message has carried it, which rounds the pose's rotation to a quaternion.
/// Whoever hands samples on without a message applies this, so that both ways give the same bits.
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

/// Motion over one stretch of time, in the axes of the robot *at the end* of it (the heading turns first,
/// then the robot moves along it: the reference arithmetic of docs/model.md). A planar odometry has left = up = 0.
struct OdometryStep {
  double dt = 0.0;        ///< [s]
  double rotation = 0.0;  ///< change of heading [rad]
  double forward = 0.0;   ///< [m], negative when reversing
  double left = 0.0;      ///< [m]
  double up = 0.0;        ///< [m]
  /// None: the source does not say.
  std::optional<StepCovariance> covariance;
  std::optional<UnitOfLength> unit;
  bool new_unit = false;  ///< the unit of length has nothing to do with the one before this step
  bool bridged = false;   ///< predicted, not measured
  /// Attitude at the end but for the yaw (odometry/uncertainty.h).
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
