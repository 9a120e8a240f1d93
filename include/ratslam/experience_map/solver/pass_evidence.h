/// What passes over known ground say of the ways between its experiences.
///
/// On known ground (pose_graph_map.h) a recall makes no node of its own. The way from one recall to the next
/// says instead where the second experience lies in the frame of the first: recall, odometry, recall. All such
/// passes are one constraint of the pose graph, their mean, which knows the more the more there were. It fades:
/// beyond kMostPasses the newest takes the place of the oldest, so that a map does not outlive what it shows.
///
/// The graph is told of a way's first pass, of its second, fourth, ..., and whenever the mean has moved away
/// from what it was told: a place that is passed every day costs the solver nothing in the end.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "ratslam/experience_map/solver/pose_graph.h"
#include "ratslam/experience_map/solver/uncertain_pose.h"

namespace ratslam {

class State;

class PassEvidence {
 public:
  /// One more pass from a node to another. @param way  in the map's unit
  void add(std::uint32_t from, std::uint32_t to, const UncertainPose& way);

  /// Tells the graph what is due, which must be at rest: constraints that take part in an iteration do not
  /// change. @return whether there was anything
  bool tell(PoseGraph& graph);

  std::size_t ways() const { return ways_.size(); }
  /// Passes that are in the mean of a way; 0 where there is none.
  double passes(std::uint32_t from, std::uint32_t to) const;

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit the graph
  void load(const State& state, const PoseGraph& graph);

 private:
  struct Way {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    UncertainPose mean;
    double passes = 0.0;
    std::uint32_t tell_at = 1;  ///< passes
    RelativePose told;
    std::uint64_t constraint = 0;  ///< of the graph, counted from 1; 0: not told yet
    bool due = false;

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("from", from);
      fields("to", to);
      fields("mean", mean);
      fields("passes", passes);
      fields("tell_at", tell_at);
      fields("told", told);
      fields("constraint", constraint);
      fields("due", due);
    }
  };

  std::vector<Way> ways_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> index_;  ///< by from and to
  std::set<std::size_t> due_;
};

/// The constraint that says this; one whose kernel doubts it where it disagrees.
Constraint recallConstraintOf(std::uint32_t from, std::uint32_t to, const UncertainPose& way);

}  // namespace ratslam
