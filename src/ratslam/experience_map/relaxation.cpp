#include "ratslam/experience_map/relaxation.h"

#include <algorithm>
#include <cmath>
#include <limits>

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
    const auto at = later - springs_.begin();
    springs_.insert(later, {link.from, link.to, link.distance, link.heading_rad, link.facing_rad});
    directions_.insert(directions_.begin() + at, std::numeric_limits<double>::quiet_NaN());
    ends_.insert(ends_.begin() + at, Place{0.0, 0.0});
  }
  stale_.resize(springs_.size());
}

void Relaxation::sweepFacings() {
  double* const facings = facings_.data();
  const double correction_share = correction_;
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    const Spring& spring = springs_[k];
    const double start = facings[spring.from];
    const double end = facings[spring.to];
    const double correction = correction_share * wrapAngle(end - (start + spring.facing_rad));
    facings[spring.from] = start + correction;
    facings[spring.to] = end - correction;
    const double direction = start + spring.heading_rad;
    stale_[k] = direction != directions_[k];
    directions_[k] = direction;
  }
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    if (!stale_[k]) continue;
    const double direction = directions_[k];
    const double cosine = std::cos(direction);
    const double sine = std::sin(direction);
    ends_[k] = {springs_[k].distance * cosine, springs_[k].distance * sine};
  }
}

void Relaxation::sweepPlaces() {
  for (std::size_t k = 0; k < springs_.size(); ++k) {
    Place& start = places_[springs_[k].from];
    Place& end = places_[springs_[k].to];
    const double dx = correction_ * (end.x - (start.x + ends_[k].x));
    const double dy = correction_ * (end.y - (start.y + ends_[k].y));
    start.x += dx;
    start.y += dy;
    end.x -= dx;
    end.y -= dy;
  }
}

}  // namespace ratslam
