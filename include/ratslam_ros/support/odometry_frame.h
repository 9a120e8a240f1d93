/// The robot's pose in the odometry's own frame at a given stamp, for map -> odom (REP-105).
///
/// It is the pose that the odometry publishes, interpolated between two messages; for a source of twists alone, the sum
/// of the twists.
#pragma once

#include <deque>
#include <optional>

#include "ratslam/experience_map/map_pose.h"
#include "ratslam/odometry/odometry.h"
#include "ratslam/system/event_gate.h"

namespace ratslam {

class OdometryFrame {
 public:
  /// Appends a sample. Samples that are not finite and repeated stamps are left out. If the stamp goes back, everything
  /// starts anew. If poseAt() is not called for very many samples, the oldest are forgotten.
  void add(const OdometrySample& sample);
  /// Appends a sample that a stage has taken.
  void follow(const DecidedSample& decided);

  /// Position and yaw at `stamp`; none before the first sample and after the newest. Earlier samples are forgotten.
  std::optional<RelativePose> poseAt(Stamp stamp);

 private:
  struct Entry {
    Stamp stamp = 0;
    RelativePose pose;
  };
  std::deque<Entry> entries_;
};

/// The transform map -> odom that makes map -> base_link the robot's pose in the map.
Eigen::Isometry3d mapToOdom(const MapPose& robot_in_map, const RelativePose& robot_in_odom);

}  // namespace ratslam
