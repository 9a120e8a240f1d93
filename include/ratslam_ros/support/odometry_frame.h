/// Where the robot was in the odometry's own frame at a given stamp, as map -> odom needs it (REP-105).
///
/// The pose the odometry itself publishes, between two messages in proportion to time; for a source of mere
/// twists the twists added up.
#pragma once

#include <deque>
#include <optional>

#include "ratslam/experience_map/map_pose.h"
#include "ratslam/odometry/odometry.h"

namespace ratslam {

class OdometryFrame {
 public:
  /// Appends a sample. Not finite ones and repeated stamps are left out; a stamp that goes back starts anew. Of
  /// very many samples that nobody asks about the oldest are forgotten.
  void add(const OdometrySample& sample);

  /// Position and yaw at `stamp`; none before the first sample and after the newest. Earlier stamps are
  /// forgotten.
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
