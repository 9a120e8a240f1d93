/// Poses of the map with the odometry's local scale, and motion measured relative to them.
///
/// A pose of the map holds the logarithm of its local scale: the factor from the odometry's unit of length to
/// the map's. compose(a, m) applies it, between(a, b) removes it. Source: the weighted graph of pose_graph.h.
#pragma once

#include <cmath>

#include "ratslam/common/angles.h"
#include "ratslam/common/stamp.h"
#include "ratslam/experience_map/motion_error.h"
#include "ratslam/odometry/odometry.h"

namespace ratslam {

struct MapPose {
  double x = 0.0;          ///< [m]
  double y = 0.0;          ///< [m]
  double z = 0.0;          ///< [m], up
  double yaw = 0.0;        ///< heading [rad]
  double log_scale = 0.0;  ///< logarithm of map metres per metre of odometry

  double scale() const { return std::exp(log_scale); }

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("x", x);
    fields("y", y);
    fields("z", z);
    fields("yaw", yaw);
    fields("log_scale", log_scale);
  }
};

struct StampedPose {
  Stamp stamp = 0;
  MapPose pose;
  /// Attitude without the yaw, from the odometry.
  Eigen::Quaterniond tilt = Eigen::Quaterniond::Identity();

  Eigen::Quaterniond attitude() const {
    return Eigen::Quaterniond(Eigen::AngleAxisd(pose.yaw, Eigen::Vector3d::UnitZ())) * tilt;
  }

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("stamp", stamp);
    fields("pose", pose);
    fields("tilt", tilt);
  }
};

/// A pose in the axes of another one, in the odometry's unit of length.
struct RelativePose {
  double x = 0.0;
  double y = 0.0;
  double z = 0.0;
  double yaw = 0.0;  ///< [rad]

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("x", x);
    fields("y", y);
    fields("z", z);
    fields("yaw", yaw);
  }
};

/// Odometry accumulated from a pose of the map on.
struct Motion {
  RelativePose pose;
  double length = 0.0;  ///< length of the path, forwards or backwards, in the odometry's unit
  MotionError error;

  /// Adds a step: first the heading turns, then the robot moves (the reference arithmetic of docs/model.md).
  void add(const OdometryStep& step) {
    pose.yaw = wrapAngle(pose.yaw + step.rotation);
    const double c = std::cos(pose.yaw);
    const double s = std::sin(pose.yaw);
    pose.x += step.forward * c - step.left * s;
    pose.y += step.forward * s + step.left * c;
    pose.z += step.up;
    const double way = std::sqrt(step.forward * step.forward + step.left * step.left + step.up * step.up);
    length += way;
    error.add(step, c, s, way);
  }

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("pose", pose);
    fields("length", length);
    fields("error", error);
  }
};

/// The pose reached from `a` by the motion `m`, at the scale of `a`. At scale 1 its bits are those of the
/// composition in SE(2).
inline MapPose compose(const MapPose& a, const RelativePose& m) {
  const double scale = a.scale();
  const double c = scale * std::cos(a.yaw);
  const double s = scale * std::sin(a.yaw);
  return {a.x + c * m.x - s * m.y, a.y + s * m.x + c * m.y, a.z + scale * m.z, wrapAngle(a.yaw + m.yaw),
          a.log_scale};
}

/// The pose of `b` in the frame of `a`, in the odometry's unit: compose(a, between(a, b)) lies at `b`.
inline RelativePose between(const MapPose& a, const MapPose& b) {
  const double c = std::cos(a.yaw);
  const double s = std::sin(a.yaw);
  const double per_metre = std::exp(-a.log_scale);
  const double dx = per_metre * (b.x - a.x);
  const double dy = per_metre * (b.y - a.y);
  return {c * dx + s * dy, -s * dx + c * dy, per_metre * (b.z - a.z), wrapAngle(b.yaw - a.yaw)};
}

}  // namespace ratslam
