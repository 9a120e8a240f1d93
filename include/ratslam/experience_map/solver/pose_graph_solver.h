/// Moves the nodes of a pose graph to the optimum of its energy, in slices of bounded work, while the graph
/// grows.
///
/// Damped Gauss-Newton (Levenberg-Marquardt's damping with a line search) on iteratively reweighted least
/// squares:
///  1. order the unknowns (block_ordering.h) if there are recalls that the last order does not contain;
///  2. linearise all constraints and fill in the normal equations;
///  3. factorise them (block_cholesky.h);
///  4. solve, and go along the step as far as the energy falls. The energy never rises.
/// A slice can end in the middle of 2 or 3 when its work is used up. Steps 1 and 4 are not divided: if they take
/// more than is left, later slices get less. Nodes that are appended meanwhile follow the newest node of the
/// iteration by a similarity transform. Work is counted in operations, not in time: so the poses are a function
/// of the sequence of calls only.
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
  /// @param scale, height whether log-scale and height are unknowns, beside x, y and facing.
  /// @param tolerance step below which the optimum counts as reached [m].
  PoseGraphSolver(bool scale, bool height, double tolerance);
  PoseGraphSolver(const PoseGraphSolver&) = delete;
  PoseGraphSolver& operator=(const PoseGraphSolver&) = delete;
  ~PoseGraphSolver();

  /// Whether the nodes are at the optimum for all constraints.
  bool settled(const PoseGraph& graph) const;

  /// Whether the graph is settled and the solution also contained all nodes appended since the last recall.
  /// The similarity transform of those nodes is their optimum except where the unit of length is anchored.
  bool complete(const PoseGraph& graph) const;

  /// Works on the graph until it is settled or the work is used up.
  /// @param work in block products, about 20 ns each. @return whether nodes have moved.
  bool advance(PoseGraph& graph, std::int64_t work);

  /// Drops the present iteration. To be called if nodes or constraints that take part in it were changed.
  void abandon();

  /// The newest node of the last complete iteration, and its covariance; none before the first one. Parts of a
  /// pose that are no unknowns have no variance.
  std::optional<std::pair<std::uint32_t, NodeCovariance>> newestCovariance() const;

  /// Covariance of any node of that iteration; none before the first one.
  std::optional<NodeCovariance> covarianceOf(std::uint32_t node) const;

  /// Size of the last step [m].
  double lastStep() const;

  /// Saves the progress of the iteration. The sums and factors computed so far follow from the graph and are not
  /// saved.
  void save(State& state) const;
  /// Repeats the saved part of the iteration, to the last bit. @param graph as it was when the state was saved.
  /// @throws std::runtime_error naming what is missing or does not fit the graph
  void load(const State& state, const PoseGraph& graph);

 private:
  class Iteration;
  template <int Size>
  class SizedIteration;
  std::unique_ptr<Iteration> iteration_;
};

}  // namespace ratslam
