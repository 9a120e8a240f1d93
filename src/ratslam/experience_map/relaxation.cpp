#include "ratslam/experience_map/relaxation.h"

#include <algorithm>
#include <cmath>

namespace ratslam {

MapPose Relaxation::framePose(const ExperienceGraph& graph, std::uint32_t frame) const {
  return graph.pose(frame);
}

RobotPlace Relaxation::create(const ExperienceGraph& graph, const RobotPlace&, const RecallGeometry*) {
  return {static_cast<std::uint32_t>(graph.experiences().size() - 1), Motion{}};
}

RobotPlace Relaxation::recall(const ExperienceGraph&, std::uint32_t experience, const RobotPlace&,
                              double relative_rad, const RecallGeometry*) {
  RobotPlace robot{experience, Motion{}};
  robot.motion.pose.yaw = wrapAngle(relative_rad);
  return robot;
}

void Relaxation::update(ExperienceGraph& graph, RobotPlace& robot) {
  const double yaw_before = graph.pose(robot.frame).yaw;
  takeNewLinks(graph);
  places_.clear();
  for (const Experience& experience : graph.experiences()) {
    places_.push_back({experience.pose.x, experience.pose.y, experience.pose.yaw});
  }
  for (int sweep = 0; sweep < sweeps_; ++sweep) {
    for (Spring& spring : springs_) relax(spring, places_[spring.from], places_[spring.to]);
  }
  graph.setPoses([this](std::uint32_t id) {
    return MapPose{places_[id].x, places_[id].y, 0.0, places_[id].th, 0.0};
  });
  robot.motion.pose.yaw = wrapAngle(robot.motion.pose.yaw + (yaw_before - places_[robot.frame].th));
}

void Relaxation::takeNewLinks(const ExperienceGraph& graph) {
  for (; links_taken_ < graph.links().size(); ++links_taken_) {
    const Link& link = graph.links()[links_taken_];
    const auto later =
        std::upper_bound(springs_.begin(), springs_.end(), link.from,
                         [](std::uint32_t from, const Spring& spring) { return from < spring.from; });
    springs_.insert(later, {link.from, link.to, link.distance, link.heading_rad, link.facing_rad});
  }
}

void Relaxation::relax(Spring& spring, Pose2& start, Pose2& end) const {
  const double direction = start.th + spring.heading_rad;
  if (direction != spring.direction) {
    spring.direction = direction;
    spring.along_x = spring.distance * std::cos(direction);
    spring.along_y = spring.distance * std::sin(direction);
  }
  const double dx = correction_ * (end.x - (start.x + spring.along_x));
  const double dy = correction_ * (end.y - (start.y + spring.along_y));
  const double df = correction_ * wrapAngle(end.th - (start.th + spring.facing_rad));
  start = {start.x + dx, start.y + dy, start.th + df};
  end = {end.x - dx, end.y - dy, end.th - df};
}

}  // namespace ratslam
