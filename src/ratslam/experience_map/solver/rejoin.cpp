#include "ratslam/experience_map/solver/rejoin.h"

#include <algorithm>
#include <cmath>
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
  std::vector<bool> within;    ///< for each constraint of the graph, whether it is part of the stretch
  std::uint32_t beyond = 0;    ///< first node that moves
  double least = kMostEnergy;  ///< energy of the loosest constraint alone, after the move
  double shares = 0.0;         ///< sum of the inverse energies

  double energy() const { return 1.0 / shares; }
};

std::vector<LooseStretch> looseStretches(const PoseGraph& graph, const Constraint& recall,
                                         const RigidMove& move) {
  std::vector<LooseStretch> stretches;
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
    if (!open) stretches.push_back({std::vector<bool>(graph.constraints().size()), 0, kMostEnergy, 0.0});
    open = true;
    LooseStretch& stretch = stretches.back();
    stretch.within[k] = true;
    stretch.shares += 1.0 / std::max(energy, 1e-9);
    if (energy < stretch.least) {
      stretch.least = energy;
      stretch.beyond = constraint.to;
    }
  }
  return stretches;
}

/// Energy that is saved by moving the nodes beyond a stretch.
double gainOf(const PoseGraph& graph, const LooseStretch& stretch, const RigidMove& move) {
  double gain = -stretch.energy();
  for (std::size_t k = 0; k < graph.constraints().size(); ++k) {
    const Constraint& constraint = graph.constraints()[k];
    const bool from_moves = constraint.from >= stretch.beyond;
    const bool to_moves = constraint.to >= stretch.beyond;
    if (from_moves == to_moves && !stretch.within[k]) continue;
    const MapPose& from = graph.nodes()[constraint.from];
    const MapPose& to = graph.nodes()[constraint.to];
    gain += graph.energy(constraint, PoseGraph::residual(constraint, from, to).squaredNorm());
    if (stretch.within[k]) continue;
    gain -= graph.energy(
        constraint, PoseGraph::residual(constraint, from_moves ? move(from) : from, to_moves ? move(to) : to)
                        .squaredNorm());
  }
  return gain;
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
  for (const LooseStretch& stretch : looseStretches(graph, recall, move)) {
    const double gain = gainOf(graph, stretch, move);
    if (!(gain > best)) continue;
    best = gain;
    beyond = stretch.beyond;
  }
  if (!beyond) return false;
  for (std::size_t node = *beyond; node < nodes.size(); ++node) nodes[node] = move(nodes[node]);
  return true;
}

}  // namespace ratslam
