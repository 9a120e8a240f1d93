#include "ratslam/experience_map/goal_planner.h"

#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <sstream>
#include <utility>

namespace ratslam {

const Goal& GoalPlanner::setGoal(const ExperienceGraph& graph, double x, double y, std::uint32_t current,
                                 Stamp now) {
  goal_ = Goal{};
  if (!std::isfinite(x) || !std::isfinite(y)) return refuse("the goal is not a finite place");
  if (graph.experiences().empty()) return refuse("the map is still empty");
  double nearest_squared = std::numeric_limits<double>::infinity();
  for (std::uint32_t id = 0; id < graph.experiences().size(); ++id) {
    const MapPose& pose = graph.pose(id);
    const double squared = (pose.x - x) * (pose.x - x) + (pose.y - y) * (pose.y - y);
    if (squared < nearest_squared) {
      nearest_squared = squared;
      goal_.experience = id;
    }
  }
  goal_.distance = std::sqrt(nearest_squared);
  if (!(goal_.distance <= radius_)) {
    std::ostringstream why;
    why << "the goal (" << x << ", " << y << ") is " << goal_.distance
        << " m from the nearest experience, more than " << radius_ << " m";
    return refuse(why.str());
  }
  goal_.status = GoalStatus::kActive;
  since_ = now;
  links_taken_ = 0;
  seconds_to_goal_.clear();
  next_.clear();
  update(graph, current, now);
  if (goal_.status == GoalStatus::kActive && std::isinf(seconds_to_goal_[current])) {
    fail("no links lead from experience " + std::to_string(current) + " to experience " +
         std::to_string(goal_.experience));
  }
  return goal_;
}

const Goal& GoalPlanner::refuse(const std::string& why) {
  fail(why);
  return goal_;
}

const Goal& GoalPlanner::update(const ExperienceGraph& graph, std::uint32_t current, Stamp now) {
  if (goal_.status != GoalStatus::kActive) return goal_;
  takeNewLinks(graph);
  if (current == goal_.experience) {
    goal_.status = GoalStatus::kReached;
  } else if (secondsBetween(since_, now) > timeout_) {
    std::ostringstream why;
    why << "experience " << goal_.experience << " was not reached within " << timeout_ << " s";
    fail(why.str());
  } else if (now < since_) {
    fail("time went back behind the goal's");
  }
  return goal_;
}

std::vector<std::uint32_t> GoalPlanner::path(std::uint32_t current) const {
  std::vector<std::uint32_t> experiences;
  if (goal_.status != GoalStatus::kActive && goal_.status != GoalStatus::kReached) return experiences;
  if (current >= next_.size() || std::isinf(seconds_to_goal_[current])) return experiences;
  for (std::uint32_t id = current; id != goal_.experience; id = next_[id]) experiences.push_back(id);
  experiences.push_back(goal_.experience);
  return experiences;
}

void GoalPlanner::fail(const std::string& why) {
  goal_.status = GoalStatus::kFailed;
  goal_.message = why;
}

void GoalPlanner::takeNewLinks(const ExperienceGraph& graph) {
  const auto& links = graph.links();
  seconds_to_goal_.resize(graph.experiences().size(), std::numeric_limits<double>::infinity());
  next_.resize(graph.experiences().size(), goal_.experience);
  seconds_to_goal_[goal_.experience] = 0.0;

  using Entry = std::pair<double, std::uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  const auto relax = [&](std::uint32_t from, std::uint32_t to, double seconds) {
    const double through = seconds_to_goal_[to] + seconds;
    if (through < seconds_to_goal_[from]) {
      seconds_to_goal_[from] = through;
      next_[from] = to;
      open.emplace(through, from);
    }
  };
  for (; links_taken_ < links.size(); ++links_taken_) {
    const Link& link = links[links_taken_];
    relax(link.from, link.to, link.duration_s);
    relax(link.to, link.from, link.duration_s);
  }
  while (!open.empty()) {
    const auto [seconds, id] = open.top();
    open.pop();
    if (seconds > seconds_to_goal_[id]) continue;
    graph.forEachLinkOf(id, [&, at = id](std::uint32_t k) {
      relax(links[k].from == at ? links[k].to : links[k].from, at, links[k].duration_s);
    });
  }
}

}  // namespace ratslam
