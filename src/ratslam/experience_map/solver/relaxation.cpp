#include "ratslam/experience_map/solver/relaxation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ratslam {

/// Updates the facings at both ends of links.
struct Relaxation::Turning {
  const Spring* springs;
  double* facings;
  double* directions;
  double correction;

  /// @return whether the link's direction has changed since the last sweep.
  bool operator()(std::size_t i) const {
    const Spring& spring = springs[i];
    const double start = facings[spring.from];
    const double end = facings[spring.to];
    const double df = correction * wrapAngle(end - (start + spring.facing_rad));
    facings[spring.from] = start + df;
    facings[spring.to] = end - df;
    const double direction = start + spring.heading_rad;
    const bool changed = direction != directions[i];
    directions[i] = direction;
    return changed;
  }
};

/// Updates the positions at both ends of links whose sines and cosines are known.
struct Relaxation::Moving {
  const Spring* springs;
  Place* places;
  const double* sines;
  const double* cosines;
  double correction;

  void operator()(std::size_t i) const {
    const Spring& spring = springs[i];
    const Place start = places[spring.from];
    const Place end = places[spring.to];
    const double dx = correction * (end.x - (start.x + spring.distance * cosines[i]));
    const double dy = correction * (end.y - (start.y + spring.distance * sines[i]));
    places[spring.from] = {start.x + dx, start.y + dy};
    places[spring.to] = {end.x - dx, end.y - dy};
  }
};

MapPose Relaxation::framePose(const ExperienceGraph& graph, std::uint32_t frame) const {
  return graph.pose(frame);
}

RobotPlace Relaxation::create(const ExperienceGraph& graph, const RobotPlace&, const RecallGeometry*) {
  return {static_cast<std::uint32_t>(graph.experiences().size() - 1), Motion{}};
}

std::optional<RobotPlace> Relaxation::recall(const ExperienceGraph&, std::uint32_t experience,
                                             const RobotPlace&, double relative_rad, const RecallGeometry*) {
  RobotPlace robot{experience, Motion{}};
  robot.motion.pose.yaw = wrapAngle(relative_rad);
  return robot;
}

void Relaxation::update(ExperienceGraph& graph, RobotPlace& robot) {
  const double yaw_before = graph.pose(robot.frame).yaw;
  takeNewLinks(graph);
  places_.clear();
  facings_.clear();
  for (const Experience& experience : graph.experiences()) {
    places_.push_back({experience.pose.x, experience.pose.y});
    facings_.push_back(experience.pose.yaw);
  }
  sweep();
  graph.setPoses([this](std::uint32_t id) {
    return MapPose{places_[id].x, places_[id].y, 0.0, facings_[id], 0.0};
  });
  robot.motion.pose.yaw = wrapAngle(robot.motion.pose.yaw + (yaw_before - facings_[robot.frame]));
}

void Relaxation::load(const State&) {
  links_taken_ = 0;
  springs_.clear();
  directions_.clear();
  sines_.clear();
  cosines_.clear();
}

void Relaxation::takeNewLinks(const ExperienceGraph& graph) {
  for (; links_taken_ < graph.links().size(); ++links_taken_) {
    const Link& link = graph.links()[links_taken_];
    const auto later =
        std::upper_bound(springs_.begin(), springs_.end(), link.from,
                         [](std::uint32_t from, const Spring& spring) { return from < spring.from; });
    const auto position = later - springs_.begin();
    directions_.insert(directions_.begin() + position, std::numeric_limits<double>::quiet_NaN());
    sines_.insert(sines_.begin() + position, 0.0);
    cosines_.insert(cosines_.begin() + position, 0.0);
    springs_.insert(later, {link.from, link.to, link.distance, link.heading_rad, link.facing_rad});
  }
}

/// Does all sweeps as one sequence of blocks: while one block is turned, the one before is moved.
void Relaxation::sweep() {
  Block moved;
  for (int sweep = 0; sweep < sweeps_; ++sweep) {
    for (std::size_t begin = 0; begin < springs_.size(); begin += kBlock) {
      const Block turned{begin, std::min(kBlock, springs_.size() - begin)};
      turnAndMove(turned, moved);
      moved = turned;
    }
  }
  turnAndMove({}, moved);
}

void Relaxation::turnAndMove(const Block& turned, const Block& moved) {
  const Turning turn{springs_.data() + turned.begin, facings_.data(), directions_.data() + turned.begin,
                     correction_};
  const Moving move{springs_.data() + moved.begin, places_.data(), sines_.data() + moved.begin,
                    cosines_.data() + moved.begin, correction_};
  bool changed = false;
  const std::size_t both = std::min(turned.count, moved.count);
  for (std::size_t i = 0; i < both; ++i) {
    changed |= turn(i);
    move(i);
  }
  for (std::size_t i = both; i < turned.count; ++i) changed |= turn(i);
  for (std::size_t i = both; i < moved.count; ++i) move(i);
  if (changed) {
    sines_cosines_(directions_.data() + turned.begin, turned.count, sines_.data() + turned.begin,
                   cosines_.data() + turned.begin);
  }
}

}  // namespace ratslam
