/// Relative poses of experiences, measured by repeated passes over known ground.
///
/// On known ground (pose_graph_map.h) a recall makes no node. Instead, a pass from one recall to the next
/// measures the pose of the second experience in the frame of the first: recall, odometry, recall. The mean of
/// all such passes is one constraint of the pose graph; each pass reduces its covariance. The mean forgets:
/// after kMostPasses the newest pass replaces the oldest, so that the map follows a world that changes.
///
/// The constraint is updated at the first pass, the second, the fourth and so on, and whenever the mean has
/// moved away from the constraint. So a place that is passed every day costs the solver almost nothing.
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
  /// Adds a pass from one node to another. @param way  pose of `to` in the frame of `from`, in the map's unit
  void add(std::uint32_t from, std::uint32_t to, const UncertainPose& way);

  /// Updates the constraints that are due. The solver must not be within an iteration: constraints that take part
  /// in one must not change. @return whether any constraint was updated
  bool tell(PoseGraph& graph);

  std::size_t ways() const { return ways_.size(); }
  /// Number of passes in the mean between two nodes; 0 if there is no pass.
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
    std::uint32_t tell_at = 1;     ///< number of passes at which the constraint is updated next
    RelativePose told;             ///< pose that the constraint holds
    std::uint64_t constraint = 0;  ///< number of the graph's constraint from 1 on; 0: none yet
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

/// A recall constraint with this pose and covariance. Like any recall it loses weight if it disagrees.
Constraint recallConstraintOf(std::uint32_t from, std::uint32_t to, const UncertainPose& way);

}  // namespace ratslam
