/// Brings a pose graph to the optimum of its energy, in slices of bounded work, while the graph grows.
///
/// Damped Gauss-Newton (Levenberg-Marquardt's damping with a line search) on iteratively reweighted least
/// squares:
///  1. order the unknowns (block_ordering.h) when recalls have come in since the last order;
///  2. linearise all constraints and fill in the normal equations;
///  3. factorise them (block_cholesky.h);
///  4. solve, and walk along the step as far as the energy falls; the energy never rises.
/// A slice ends in the middle of 2 or 3 when its work is used up; what 1 or 4 take beyond that, later slices
/// go without. Nodes that are appended in the meantime lie on the chain behind the newest node that takes
/// part, and are carried along by a similarity. Work is counted in operations, not in time, so the poses are
/// a function of the sequence of calls only.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "ratslam/experience_map/solver/pose_graph.h"

namespace ratslam {

class State;

class PoseGraphSolver {
 public:
  /// @param scale, height which parts of a pose are unknowns beside x, y and facing.
  /// @param tolerance step below which the optimum counts as reached [m].
  PoseGraphSolver(bool scale, bool height, double tolerance);
  PoseGraphSolver(const PoseGraphSolver&) = delete;
  PoseGraphSolver& operator=(const PoseGraphSolver&) = delete;
  ~PoseGraphSolver();

  /// Whether the nodes are at the optimum for all constraints.
  bool settled(const PoseGraph& graph) const;

  /// Whether they are, and what has been appended to the chain since the last recall took part in the
  /// solution, too: it is carried along by a similarity, which is the optimum but for a unit of length that
  /// returns to its anchor.
  bool complete(const PoseGraph& graph) const;

  /// Works on the graph until it is settled or the work is used up. @param work in block products, about 20
  /// ns each.
  /// @return whether nodes have moved.
  bool advance(PoseGraph& graph, std::int64_t work);

  /// Drops the iteration it is in: nodes or constraints that take part in it have been changed.
  void abandon();

  /// Covariance of the newest node that took part in the last iteration, and which one that is; none where no
  /// iteration has come to its end. Parts of a pose that are no unknowns are exact.
  std::optional<std::pair<std::uint32_t, NodeCovariance>> newestCovariance() const;

  /// Covariance of any node that took part in it; none likewise.
  std::optional<NodeCovariance> covarianceOf(std::uint32_t node) const;

  /// Size of the last step taken [m]: how far from settled the graph was.
  double lastStep() const;

  /// How far it has got. What it has summed up and factorised so far follows from the graph and is not saved.
  void save(State& state) const;
  /// Does again what the saved one had done of its present iteration, to the last bit.
  /// @param graph as it was when the state was saved: a constraint that takes part in an iteration does not
  /// change before its end. @throws std::runtime_error naming what is missing or does not fit the graph
  void load(const State& state, const PoseGraph& graph);

 private:
  class Iteration;
  template <int Size>
  class SizedIteration;
  std::unique_ptr<Iteration> iteration_;
};

}  // namespace ratslam
