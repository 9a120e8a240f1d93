/// Passes goals from a topic to the map, and publishes the path to the goal and messages about its status.
#pragma once

#include <geometry_msgs/PoseStamped.h>

#include <string>

#include "ratslam/experience_map/experience_map.h"
#include "ratslam_ros/support/map_publisher.h"

namespace ratslam {

class GoalReporter {
 public:
  /// @throws std::runtime_error for a goal in another frame than `map_frame`, or one that is not finite
  void take(const geometry_msgs::PoseStamped& goal, const std::string& map_frame, ExperienceMap& map,
            MapPublisher& publisher);

  /// To be called when another map has been loaded, which has no goal.
  void forget() { status_ = GoalStatus::kNone; }

  /// Reports changes of the goal since the last call, and publishes the path to a new or active goal.
  /// @param moved  whether the map has processed a decision since the last call; if not, the path is the same
  void report(const ExperienceMap& map, MapPublisher& publisher, bool moved);

 private:
  GoalStatus status_ = GoalStatus::kNone;
};

}  // namespace ratslam
