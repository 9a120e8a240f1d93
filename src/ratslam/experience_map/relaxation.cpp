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
  facings_.clear();
  places_.clear();
  for (const Experience& experience : graph.experiences()) {
    facings_.push_back(experience.pose.yaw);
    places_.push_back({experience.pose.x, experience.pose.y});
  }
  for (int sweep = 0; sweep < sweeps_; ++sweep) {
    sweepFacings();
    sweepPlaces();
  }
  graph.setPoses([this](std::uint32_t id) {
    return MapPose{places_[id].x, places_[id].y, 0.0, facings_[id], 0.0};
  });
  robot.motion.pose.yaw = wrapAngle(robot.motion.pose.yaw + (yaw_before - facings_[robot.frame]));
}

void Relaxation::takeNewLinks(const ExperienceGraph& graph) {
  for (; links_taken_ < graph.links().size(); ++links_taken_) {
    const Link& link = graph.links()[links_taken_];
    const auto later =
        std::upper_bound(springs_.begin(), springs_.end(), link.from,
                         [](std::uint32_t from, const Spring& spring) { return from < spring.from; });
    springs_.insert(later, {link.from, link.to, link.distance, link.heading_rad, link.facing_rad});
  }
  directions_.resize(springs_.size());
  ends_x_.resize(springs_.size());
  ends_y_.resize(springs_.size());
}

void Relaxation::sweepFacings() {
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    const Spring& spring = springs_[k];
    double& start = facings_[spring.from];
    double& end = facings_[spring.to];
    directions_[k] = start + spring.heading_rad;
    const double correction = correction_ * wrapAngle(end - (start + spring.facing_rad));
    start += correction;
    end -= correction;
  }
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    ends_x_[k] = springs_[k].distance * std::cos(directions_[k]);
    ends_y_[k] = springs_[k].distance * std::sin(directions_[k]);
  }
}

void Relaxation::sweepPlaces() {
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    Place& start = places_[springs_[k].from];
    Place& end = places_[springs_[k].to];
    const double dx = correction_ * (end.x - (start.x + ends_x_[k]));
    const double dy = correction_ * (end.y - (start.y + ends_y_[k]));
    start.x += dx;
    start.y += dy;
    end.x -= dx;
    end.y -= dy;
  }
}

}  // namespace ratslam
