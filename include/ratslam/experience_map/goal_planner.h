/// Path planning over the experience map: the quickest way known from experience.
///
/// Steps: a goal (x, y) selects the nearest experience within a radius; Dijkstra's algorithm from there over
/// the links, in both directions, weighted by duration, gives every experience its time to the goal; the path
/// follows it from the robot's experience. Links that the map gains meanwhile can only shorten times, so they
/// are relaxed into the same tree.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ratslam/experience_map/experience_graph.h"

namespace ratslam {

enum class GoalStatus { kNone, kActive, kReached, kFailed };

struct Goal {
  GoalStatus status = GoalStatus::kNone;
  std::uint32_t experience = 0;  ///< that the goal selected
  double distance = 0.0;         ///< of the goal from that experience [m]
  std::string message;           ///< why it failed, empty otherwise

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("status", status);
    fields("experience", experience);
    fields("distance", distance);
    fields("message", message);
  }
};

class GoalPlanner {
 public:
  /// @param radius greatest distance of a goal from the nearest experience [m].
  /// @param timeout time allowed for reaching a goal [s].
  GoalPlanner(double radius, double timeout) : radius_(radius), timeout_(timeout) {}

  /// Replaces the goal. @param current experience where the robot is. @param now newest stamp of the map.
  const Goal& setGoal(const ExperienceGraph& graph, double x, double y, std::uint32_t current, Stamp now);

  /// Fails a goal that there is no map for yet.
  const Goal& refuse(const std::string& why);

  /// Looks whether the goal is reached or out of time; to be called whenever the robot or the map has moved
  /// on.
  const Goal& update(const ExperienceGraph& graph, std::uint32_t current, Stamp now);

  const Goal& goal() const { return goal_; }

  /// Experiences from `current` to the goal, both included; empty unless the goal is active or reached.
  std::vector<std::uint32_t> path(std::uint32_t current) const;

  /// What it knows, for common/state.h.
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("goal", goal_);
    fields("since", since_);
    fields("links_taken", links_taken_);
    fields("seconds_to_goal", seconds_to_goal_);
    fields("next", next_);
  }

 private:
  void fail(const std::string& why);
  void takeNewLinks(const ExperienceGraph& graph);

  double radius_;
  double timeout_;
  Goal goal_;
  Stamp since_ = 0;
  std::uint64_t links_taken_ = 0;
  std::vector<double> seconds_to_goal_;  ///< of each experience, infinite where no way is known
  std::vector<std::uint32_t> next_;      ///< experience that follows on the way to the goal
};

}  // namespace ratslam
