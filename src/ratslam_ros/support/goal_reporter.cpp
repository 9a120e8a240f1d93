#include "ratslam_ros/support/goal_reporter.h"

#include <ros/console.h>

#include <cmath>
#include <stdexcept>

#include "ratslam/common/text_file.h"

namespace ratslam {

void GoalReporter::take(const geometry_msgs::PoseStamped& goal, const std::string& map_frame,
                        ExperienceMap& map, MapPublisher& publisher) {
  if (!goal.header.frame_id.empty() && goal.header.frame_id != map_frame) {
    throw std::runtime_error("the goal is given in frame '" + shown(goal.header.frame_id) + "', not in '" +
                             map_frame + "'");
  }
  if (!std::isfinite(goal.pose.position.x) || !std::isfinite(goal.pose.position.y)) {
    throw std::runtime_error("the goal's position is not finite");
  }
  status_ = GoalStatus::kNone;
  map.setGoal(goal.pose.position.x, goal.pose.position.y);
  report(map, publisher, false);
}

void GoalReporter::report(const ExperienceMap& map, MapPublisher& publisher, bool moved) {
  const Goal& goal = map.goal();
  const bool on_the_way = moved && goal.status == GoalStatus::kActive;
  if (goal.status == GoalStatus::kNone || (goal.status == status_ && !on_the_way)) return;
  if (goal.status != status_) {
    if (goal.status == GoalStatus::kFailed) ROS_ERROR("goal failed: %s", goal.message.c_str());
    if (goal.status == GoalStatus::kReached) ROS_INFO("goal reached");
    if (goal.status == GoalStatus::kActive) {
      ROS_INFO("heading for experience %u, %.2f m from the goal", goal.experience, goal.distance);
    }
  }
  status_ = goal.status;
  publisher.publishPath(map);
}

}  // namespace ratslam
