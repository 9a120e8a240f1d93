/// Path planning over the experience map: the path of the shortest known duration.
///
/// Steps:
///  1. A goal (x, y) selects the nearest experience within a radius.
///  2. Dijkstra's algorithm runs from there over the links, in both directions, weighted by duration. It gives
///     each experience its time to the goal and the next experience on the path.
///  3. The path follows these from the current experience.
/// New links can only shorten times. So they are relaxed into the same tree.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "ratslam/experience_map/experience_graph.h"

namespace ratslam {

enum class GoalStatus { kNone, kActive, kReached, kFailed };

struct Goal {
  GoalStatus status = GoalStatus::kNone;
  std::uint32_t experience = 0;  ///< the experience nearest to the goal
  double distance = 0.0;         ///< of the goal from that experience [m]
  std::string message;           ///< why the goal failed; empty otherwise

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

  /// Replaces the goal. @param x, y [m] in the map. @param current current experience. @param now newest stamp.
  const Goal& setGoal(const ExperienceGraph& graph, double x, double y, std::uint32_t current, Stamp now);

  /// Sets a failed goal, for example when there is no map yet. @param why  its message
  const Goal& refuse(const std::string& why);

  /// Checks whether the goal is reached or has timed out. To be called after each change of the current
  /// experience, the stamp or the map.
  const Goal& update(const ExperienceGraph& graph, std::uint32_t current, Stamp now);

  const Goal& goal() const { return goal_; }

  /// Experiences from `current` to the goal, both included; empty unless the goal is active or reached.
  std::vector<std::uint32_t> path(std::uint32_t current) const;

  /// For common/state.h.
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
  std::vector<double> seconds_to_goal_;  ///< of each experience; infinite if no path is known
  std::vector<std::uint32_t> next_;      ///< of each experience, the next one on the path to the goal
};

}  // namespace ratslam
