#include "ratslam/experience_map/solver/rejoin.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include "ratslam/common/angles.h"

namespace ratslam {
namespace {

/// Below this weight by the kernel the solver will hardly follow a recall.
constexpr double kDoubted = 0.1;
/// A constraint is loose if the move would give it less than this energy.
constexpr double kMostEnergy = 400.0;
/// A move must lower the energy by at least this.
constexpr double kGain = 1.0;

/// A rigid motion in the plane, and along z.
class RigidMove {
 public:
  /// The motion that takes `before` to `after`; scales do not matter.
  RigidMove(const MapPose& before, const MapPose& after)
      : before_(before), after_(after), turn_(wrapAngle(after.yaw - before.yaw)) {}

  MapPose operator()(MapPose pose) const {
    const double dx = pose.x - before_.x;
    const double dy = pose.y - before_.y;
    pose.x = after_.x + std::cos(turn_) * dx - std::sin(turn_) * dy;
    pose.y = after_.y + std::sin(turn_) * dx + std::cos(turn_) * dy;
    pose.z += after_.z - before_.z;
    pose.yaw = wrapAngle(pose.yaw + turn_);
    return pose;
  }

 private:
  MapPose before_;
  MapPose after_;
  double turn_;
};

/// The robot's pose according to a recall.
MapPose recalledPose(const MapPose& from, const RelativePose& measured) {
  MapPose pose = from;
  pose.x += std::cos(from.yaw) * measured.x - std::sin(from.yaw) * measured.y;
  pose.y += std::sin(from.yaw) * measured.x + std::cos(from.yaw) * measured.y;
  pose.z += measured.z;
  pose.yaw = wrapAngle(from.yaw + measured.yaw);
  return pose;
}

/// Consecutive loose constraints of the chain. They share the disagreement, so that the nodes beyond can move.
struct LooseStretch {
  std::uint32_t beyond = 0;    ///< first node that moves
  double least = kMostEnergy;  ///< energy of the loosest constraint alone, after the move
  double shares = 0.0;         ///< sum of the inverse energies
  double gain = 0.0;           ///< energy that is saved by moving the nodes beyond
};

/// The loose stretches of the chain between the two ends of a recall.
struct LooseChain {
  std::vector<LooseStretch> stretches;
  std::vector<std::size_t> stretch_of;  ///< for each constraint of the graph; kNone: it is part of no stretch
};
constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

LooseChain looseChain(const PoseGraph& graph, const Constraint& recall, const RigidMove& move) {
  LooseChain chain;
  chain.stretch_of.assign(graph.constraints().size(), kNone);
  bool open = false;
  for (std::size_t k = 0; k < graph.constraints().size(); ++k) {
    const Constraint& constraint = graph.constraints()[k];
    if (constraint.closes() || constraint.to <= recall.from || constraint.to > recall.to) continue;
    const MapPose& from = graph.nodes()[constraint.from];
    const MapPose& to = graph.nodes()[constraint.to];
    const double energy = PoseGraph::residual(constraint, from, move(to)).squaredNorm();
    if (!(energy < kMostEnergy)) {
      open = false;
      continue;
    }
    if (!open) chain.stretches.emplace_back();
    open = true;
    chain.stretch_of[k] = chain.stretches.size() - 1;
    LooseStretch& stretch = chain.stretches.back();
    stretch.shares += 1.0 / std::max(energy, 1e-9);
    if (energy < stretch.least) {
      stretch.least = energy;
      stretch.beyond = constraint.to;
    }
  }
  return chain;
}

/// Fills in LooseStretch::gain.
///
/// A constraint changes its energy if one of its ends moves. That is always its later node, and the change is the
/// same for all stretches between its ends. So each constraint is looked at once, not once for each stretch.
void addUpGains(const PoseGraph& graph, const RigidMove& move, LooseChain& chain) {
  std::vector<LooseStretch>& stretches = chain.stretches;
  std::vector<std::size_t> along_nodes(stretches.size());  // the stretches by their first node that moves
  std::iota(along_nodes.begin(), along_nodes.end(), std::size_t{0});
  std::stable_sort(along_nodes.begin(), along_nodes.end(),
                   [&](std::size_t a, std::size_t b) { return stretches[a].beyond < stretches[b].beyond; });
  // The place in along_nodes of the first stretch that moves no node before `node`.
  const auto placeOf = [&](std::uint32_t node) {
    const auto found =
        std::lower_bound(along_nodes.begin(), along_nodes.end(), node,
                         [&](std::size_t k, std::uint32_t n) { return stretches[k].beyond < n; });
    return static_cast<std::size_t>(found - along_nodes.begin());
  };

  std::vector<double> steps(stretches.size() + 1);  // of the recalls' gain, from one stretch to the next
  for (std::size_t k = 0; k < graph.constraints().size(); ++k) {
    const Constraint& constraint = graph.constraints()[k];
    const bool to_moves = constraint.from < constraint.to;
    const std::size_t first = placeOf(std::min(constraint.from, constraint.to) + 1);
    const std::size_t end = placeOf(std::max(constraint.from, constraint.to) + 1);
    const std::size_t own = chain.stretch_of[k];
    if (first == end && own == kNone) continue;
    const MapPose& from = graph.nodes()[constraint.from];
    const MapPose& to = graph.nodes()[constraint.to];
    const double before = graph.energy(constraint, PoseGraph::residual(constraint, from, to).squaredNorm());
    if (own != kNone) stretches[own].gain += before;
    if (first == end) continue;
    const double after = graph.energy(
        constraint, PoseGraph::residual(constraint, to_moves ? from : move(from), to_moves ? move(to) : to)
                        .squaredNorm());
    if (constraint.closes()) {
      steps[first] += before - after;
      steps[end] -= before - after;
    } else {  // short, but of any energy: added to the steps and subtracted again, it would drown them
      for (std::size_t place = first; place < end; ++place) {
        if (along_nodes[place] != own) stretches[along_nodes[place]].gain += before - after;
      }
    }
  }
  double recalls = 0.0;
  for (std::size_t place = 0; place < along_nodes.size(); ++place) {
    recalls += steps[place];
    LooseStretch& stretch = stretches[along_nodes[place]];
    stretch.gain += recalls - 1.0 / stretch.shares;
  }
}

}  // namespace

bool rejoin(PoseGraph& graph, const Constraint& recall) {
  std::vector<MapPose>& nodes = graph.nodes();
  const MapPose& from = nodes[recall.from];
  const MapPose& to = nodes[recall.to];
  if (graph.weight(recall, PoseGraph::residual(recall, from, to).squaredNorm()) > kDoubted) return false;
  const RigidMove move(to, recalledPose(from, recall.measured));
  std::optional<std::uint32_t> beyond;
  double best = kGain;
  LooseChain chain = looseChain(graph, recall, move);
  addUpGains(graph, move, chain);
  for (const LooseStretch& stretch : chain.stretches) {
    if (!(stretch.gain > best)) continue;
    best = stretch.gain;
    beyond = stretch.beyond;
  }
  if (!beyond) return false;
  for (std::size_t node = *beyond; node < nodes.size(); ++node) nodes[node] = move(nodes[node]);
  return true;
}

}  // namespace ratslam
