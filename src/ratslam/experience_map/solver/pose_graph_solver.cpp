#include "ratslam/experience_map/solver/pose_graph_solver.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ratslam/common/state.h"
#include "ratslam/experience_map/solver/block_cholesky.h"

namespace ratslam {
namespace {

/// Cost of the other parts of an iteration, in block products.
constexpr std::int64_t kWorkPerLinearisation = 12;
constexpr std::int64_t kWorkPerOrderedNode = 10;
constexpr std::int64_t kWorkPerSteppedNode = 6;

constexpr int kHalvings = 8;
constexpr double kFirstDamping = 1e-4;
constexpr double kGreatestDamping = 1e8;

}  // namespace

class PoseGraphSolver::Iteration {
 public:
  Iteration() = default;
  Iteration(const Iteration&) = delete;
  Iteration& operator=(const Iteration&) = delete;
  virtual ~Iteration() = default;
  virtual bool settled(const PoseGraph& graph) const = 0;
  virtual bool complete(const PoseGraph& graph) const = 0;
  virtual bool advance(PoseGraph& graph, std::int64_t work) = 0;
  virtual void abandon() = 0;
  virtual double lastStep() const = 0;
  virtual std::uint32_t newest() const = 0;
  virtual std::optional<NodeCovariance> covarianceOf(std::uint32_t node) const = 0;
  virtual void save(State& state) const = 0;
  virtual void load(const State& state, const PoseGraph& graph) = 0;
};

/// An iteration with `Size` unknowns per node: x, y, facing, then log-scale and height if they are unknowns.
template <int Size>
class PoseGraphSolver::SizedIteration : public PoseGraphSolver::Iteration {
 public:
  SizedIteration(const std::array<int, Size>& components, double tolerance)
      : components_(components), tolerance_(tolerance) {}

  bool settled(const PoseGraph& graph) const override {
    return stage_ == Stage::kIdle && evidence_ == graph.evidence();
  }

  bool complete(const PoseGraph& graph) const override {
    return settled(graph) && (evidence_ == 0 || constraints_ == graph.constraints().size());
  }

  void abandon() override { stage_ = Stage::kIdle; }

  double lastStep() const override { return last_step_; }

  std::uint32_t newest() const override { return nodes_ - 1; }

  std::optional<NodeCovariance> covarianceOf(std::uint32_t node) const override {
    if (!at_optimum_ || node >= nodes_ || nodes_ < 2) return std::nullopt;
    if (node == 0) return NodeCovariance::Zero();
    const Block block = cholesky_.inverseAt(structure_.position[node - 1]);
    NodeCovariance covariance = NodeCovariance::Zero();
    for (int column = 0; column < Size; ++column) {
      for (int row = 0; row < Size; ++row) {
        covariance(components_[static_cast<std::size_t>(row)],
                   components_[static_cast<std::size_t>(column)]) = block(row, column);
      }
    }
    return covariance;
  }

  bool advance(PoseGraph& graph, std::int64_t work) override {
    bool moved = false;
    // On a settled graph the work goes into the nodes that have been appended since the last order.
    if (settled(graph) && !complete(graph)) order(graph, balance_);
    // Ordering and stepping are not sliced. If they take more than is left, later slices get less.
    balance_ = std::min<std::int64_t>(balance_, 0) + work;
    while (balance_ > 0 && !settled(graph)) {
      switch (stage_) {
        case Stage::kIdle:
          order(graph, balance_);
          break;
        case Stage::kLinearise:
          linearise(graph, balance_);
          break;
        case Stage::kFactorise:
          if (cholesky_.factorise(balance_)) stage_ = Stage::kStep;
          break;
        case Stage::kStep:
          moved = step(graph, balance_) || moved;
          break;
      }
    }
    return moved;
  }

  void save(State& state) const override {
    const bool working = stage_ != Stage::kIdle;
    state.set("stage", stage_);
    state.set("balance", balance_);
    state.set("evidence", static_cast<std::uint64_t>(evidence_));
    state.set("last_step", last_step_);
    state.set("nodes", working ? nodes_ : 0U);
    state.set("constraints", static_cast<std::uint64_t>(constraints_));
    state.set("next_constraint", static_cast<std::uint64_t>(working ? next_constraint_ : 0));
    state.set("columns", working ? cholesky_.columnsDone() : 0U);
    state.set("damping", working ? damping_ : 0.0);
    if (working && steps_ > 0) state.child("steps").set("count", steps_);
  }

  void load(const State& state, const PoseGraph& graph) override {
    const auto count = [&state](const char* name) {
      return static_cast<std::size_t>(state.get<std::uint64_t>(name));
    };
    state.get("nodes", nodes_);
    constraints_ = count("constraints");
    evidence_ = count("evidence");
    const std::size_t linearised = count("next_constraint");
    const auto columns = state.get<std::uint32_t>("columns");
    const auto stage = state.get<Stage>("stage");
    state.get("balance", balance_);
    state.get("damping", damping_);
    state.get("last_step", last_step_);
    steps_ = state.hasChild("steps") ? state.child("steps").get<std::uint32_t>("count") : 0;
    stage_ = Stage::kIdle;
    if (stage == Stage::kIdle) return;
    if (nodes_ < 2 || nodes_ > graph.nodes().size() || constraints_ > graph.constraints().size() ||
        linearised > constraints_ || columns > nodes_ - 1 || stage > Stage::kStep) {
      throw std::runtime_error("state " + state.path() + ": it is not that of a solver of this graph");
    }
    orderUnknowns(graph);
    startLinearising();
    while (next_constraint_ < linearised) {
      addNormalEquations(graph, graph.constraints()[next_constraint_++]);
    }
    if (stage == Stage::kLinearise) return;
    damp();
    cholesky_.factoriseUpTo(columns);
    stage_ = stage;
  }

 private:
  enum class Stage { kIdle, kLinearise, kFactorise, kStep };
  using Vector = typename BlockCholesky<Size>::Vector;
  using Block = typename BlockCholesky<Size>::Block;

  /// Orders the unknowns of the present graph. Later nodes and constraints take part from the next order on.
  void order(const PoseGraph& graph, std::int64_t& work) {
    nodes_ = static_cast<std::uint32_t>(graph.nodes().size());
    constraints_ = graph.constraints().size();
    evidence_ = graph.evidence();
    orderUnknowns(graph);
    damping_ = 0.0;
    steps_ = 0;
    work -= kWorkPerOrderedNode * nodes_;
    startLinearising();
  }

  void orderUnknowns(const PoseGraph& graph) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
    edges.reserve(constraints_);
    for (std::size_t k = 0; k < constraints_; ++k) {
      const Constraint& constraint = graph.constraints()[k];
      // Node 0 is fixed: unknown k is node k + 1.
      if (constraint.from > 0 && constraint.to > 0)
        edges.emplace_back(constraint.from - 1, constraint.to - 1);
    }
    structure_ = orderBlocks(nodes_ - 1, edges);
  }

  void startLinearising() {
    at_optimum_ = false;
    cholesky_.reset(structure_);
    gradient_.assign(structure_.columns(), Vector::Zero());
    next_constraint_ = 0;
    energy_ = 0.0;
    stage_ = Stage::kLinearise;
  }

  void linearise(const PoseGraph& graph, std::int64_t& work) {
    for (; next_constraint_ < constraints_ && work > 0; ++next_constraint_) {
      addNormalEquations(graph, graph.constraints()[next_constraint_]);
      work -= kWorkPerLinearisation;
    }
    if (next_constraint_ < constraints_) return;
    damp();
    stage_ = Stage::kFactorise;
  }

  void damp() {
    factored_damping_ = damping_;
    for (std::uint32_t k = 0; k < nodes_ - 1 && damping_ > 0.0; ++k) {
      cholesky_.diagonal(k).diagonal() *= 1.0 + damping_;
    }
  }

  void addNormalEquations(const PoseGraph& graph, const Constraint& constraint) {
    const LinearisedConstraint linear =
        PoseGraph::linearise(constraint, graph.nodes()[constraint.from], graph.nodes()[constraint.to]);
    const double squared = linear.residual.squaredNorm();
    const double weight = graph.weight(constraint, squared);
    energy_ += graph.energy(constraint, squared);
    const Block by_from = select(linear.by_from);
    const Block by_to = select(linear.by_to);
    Vector residual;
    for (int k = 0; k < Size; ++k)
      residual[k] = weight * linear.residual[components_[static_cast<std::size_t>(k)]];
    if (constraint.from > 0) {
      const std::uint32_t from = structure_.position[constraint.from - 1];
      cholesky_.diagonal(from).noalias() += weight * by_from.transpose() * by_from;
      gradient_[from].noalias() += by_from.transpose() * residual;
    }
    if (constraint.to > 0) {
      const std::uint32_t to = structure_.position[constraint.to - 1];
      cholesky_.diagonal(to).noalias() += weight * by_to.transpose() * by_to;
      gradient_[to].noalias() += by_to.transpose() * residual;
    }
    if (constraint.from > 0 && constraint.to > 0) {
      const Block between = weight * by_from.transpose() * by_to;
      cholesky_.addBetween(structure_.position[constraint.from - 1], structure_.position[constraint.to - 1],
                           between);
    }
  }

  Block select(const ResidualJacobian& jacobian) const {
    Block block;
    for (int column = 0; column < Size; ++column) {
      for (int row = 0; row < Size; ++row) {
        block(row, column) = jacobian(components_[static_cast<std::size_t>(row)],
                                      components_[static_cast<std::size_t>(column)]);
      }
    }
    return block;
  }

  /// Moves the nodes along the Gauss-Newton step, as far as the energy falls. @return whether they moved.
  bool step(PoseGraph& graph, std::int64_t& work) {
    work -= kWorkPerSteppedNode * nodes_;
    if (++steps_ > kMostSteps) {
      finishStep(graph, true);
      at_optimum_ = false;
      return false;
    }
    if (cholesky_.definite()) {
      std::vector<Vector> full = gradient_;
      cholesky_.solve(full);
      const double before = graph.energy(graph.nodes(), constraints_, energy_);
      double share = 1.0;
      for (int halving = 0; halving <= kHalvings; ++halving, share *= 0.5) {
        std::vector<MapPose> moved = stepped(graph.nodes(), full, share);
        work -= kWorkPerSteppedNode * static_cast<std::int64_t>(moved.size());
        const double after = graph.energy(moved);
        if (!(after < before)) continue;
        last_step_ = share * largest(full);
        graph.nodes() = std::move(moved);
        damping_ = share == 1.0 ? (damping_ > kFirstDamping ? 0.1 * damping_ : 0.0)
                                : (share < 0.25 ? std::max(kFirstDamping, 10.0 * damping_) : damping_);
        finishStep(graph, last_step_ < tolerance_ && damping_ == 0.0);
        return true;
      }
      // A step this small is the optimum: only rounding decides whether the energy falls.
      if (largest(full) < kRoundingSteps * tolerance_) {
        last_step_ = 0.0;
        finishStep(graph, true);
        return false;
      }
    }
    damping_ = std::max(kFirstDamping, 10.0 * damping_);
    finishStep(graph, damping_ > kGreatestDamping);
    return false;
  }

  void finishStep(const PoseGraph& graph, bool converged) {
    at_optimum_ = converged && factored_damping_ == 0.0 && cholesky_.definite();
    if (converged || graph.evidence() != evidence_) {
      stage_ = Stage::kIdle;
    } else {
      startLinearising();
    }
  }

  /// Largest displacement of a step [m].
  static double largest(const std::vector<Vector>& step) {
    double largest_squared = 0.0;
    for (const Vector& node : step)
      largest_squared = std::max(largest_squared, node.template head<2>().squaredNorm());
    return std::sqrt(largest_squared);
  }

  std::vector<MapPose> stepped(const std::vector<MapPose>& from, const std::vector<Vector>& full,
                               double share) const {
    std::vector<MapPose> nodes = from;
    for (std::uint32_t node = 1; node < nodes_; ++node) {
      const Vector change = -share * full[structure_.position[node - 1]];
      Eigen::Matrix<double, 5, 1> all = Eigen::Matrix<double, 5, 1>::Zero();
      for (int k = 0; k < Size; ++k) all[components_[static_cast<std::size_t>(k)]] = change[k];
      MapPose& pose = nodes[node];
      pose.x += all[0];
      pose.y += all[1];
      pose.yaw = wrapAngle(pose.yaw + all[2]);
      pose.log_scale += all[3];
      pose.z += all[4];
    }
    const MapPose& old_end = from[nodes_ - 1];
    const MapPose& new_end = nodes[nodes_ - 1];
    for (std::size_t node = nodes_; node < nodes.size(); ++node) {
      MapPose carried = compose(new_end, between(old_end, from[node]));
      carried.log_scale = new_end.log_scale + (from[node].log_scale - old_end.log_scale);
      nodes[node] = carried;
    }
    return nodes;
  }

  static constexpr double kRoundingSteps = 5.0;
  /// Bound on the steps after one order. A hundred are many, but contradictory input can make endless valleys.
  static constexpr std::uint32_t kMostSteps = 1000;

  std::array<int, Size> components_;
  double tolerance_;
  Stage stage_ = Stage::kIdle;
  std::int64_t balance_ = 0;  ///< work left; negative if more was done than allowed
  std::uint32_t nodes_ = 0;
  std::size_t constraints_ = 0;
  std::size_t evidence_ = 0;
  std::size_t next_constraint_ = 0;
  double energy_ = 0.0;  ///< of the constraints linearised so far
  double damping_ = 0.0;
  double last_step_ = 0.0;
  std::uint32_t steps_ = 0;  ///< since the last order
  double factored_damping_ = 0.0;
  bool at_optimum_ = false;  ///< the factor belongs to the last optimum
  BlockStructure structure_;
  BlockCholesky<Size> cholesky_;
  std::vector<Vector> gradient_;
};

PoseGraphSolver::PoseGraphSolver(bool scale, bool height, double tolerance) {
  if (scale && height) {
    iteration_ = std::make_unique<SizedIteration<5>>(std::array<int, 5>{0, 1, 2, 3, 4}, tolerance);
  } else if (scale || height) {
    iteration_ = std::make_unique<SizedIteration<4>>(std::array<int, 4>{0, 1, 2, scale ? 3 : 4}, tolerance);
  } else {
    iteration_ = std::make_unique<SizedIteration<3>>(std::array<int, 3>{0, 1, 2}, tolerance);
  }
}

PoseGraphSolver::~PoseGraphSolver() = default;

bool PoseGraphSolver::settled(const PoseGraph& graph) const { return iteration_->settled(graph); }

bool PoseGraphSolver::advance(PoseGraph& graph, std::int64_t work) {
  return iteration_->advance(graph, work);
}

bool PoseGraphSolver::complete(const PoseGraph& graph) const { return iteration_->complete(graph); }

void PoseGraphSolver::abandon() { iteration_->abandon(); }

std::optional<std::pair<std::uint32_t, NodeCovariance>> PoseGraphSolver::newestCovariance() const {
  const std::optional<NodeCovariance> known = iteration_->covarianceOf(iteration_->newest());
  if (!known) return std::nullopt;
  return std::make_pair(iteration_->newest(), *known);
}

std::optional<NodeCovariance> PoseGraphSolver::covarianceOf(std::uint32_t node) const {
  return iteration_->covarianceOf(node);
}

double PoseGraphSolver::lastStep() const { return iteration_->lastStep(); }

void PoseGraphSolver::save(State& state) const { iteration_->save(state); }

void PoseGraphSolver::load(const State& state, const PoseGraph& graph) { iteration_->load(state, graph); }

}  // namespace ratslam
