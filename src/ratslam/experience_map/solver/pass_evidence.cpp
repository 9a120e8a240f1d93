#include "ratslam/experience_map/solver/pass_evidence.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr double kMostPasses = 16.0;  // number of passes that a mean remembers
constexpr double kMoved = 3.0;  // a mean that has moved by more updates its constraint [standard deviations]

Eigen::Vector4d apart(const RelativePose& a, const RelativePose& b) {
  return {b.x - a.x, b.y - a.y, b.z - a.z, wrapAngle(b.yaw - a.yaw)};
}

}  // namespace

Constraint recallConstraintOf(std::uint32_t from, std::uint32_t to, const UncertainPose& way) {
  Constraint constraint;
  constraint.from = from;
  constraint.to = to;
  constraint.recall = true;
  constraint.measured = way.pose;
  weigh(constraint, way.covariance);
  return constraint;
}

void PassEvidence::add(std::uint32_t from, std::uint32_t to, const UncertainPose& way) {
  const auto [known, fresh] = index_.try_emplace({from, to}, ways_.size());
  if (fresh) {
    ways_.emplace_back();
    ways_.back().from = from;
    ways_.back().to = to;
  }
  Way& passed = ways_[known->second];
  if (passed.passes >= kMostPasses) passed.mean.covariance *= kMostPasses / (kMostPasses - 1.0);
  passed.mean = fresh ? way : combined(passed.mean, way);
  passed.passes = std::min(passed.passes + 1.0, kMostPasses);
  const Eigen::Vector4d moved = apart(passed.told, passed.mean.pose);
  const bool news = passed.passes >= passed.tell_at && passed.tell_at <= kMostPasses;
  if (!passed.due && (news || moved.dot(passed.mean.covariance.llt().solve(moved)) > kMoved * kMoved)) {
    passed.due = true;
    due_.insert(known->second);
  }
}

bool PassEvidence::tell(PoseGraph& graph) {
  if (due_.empty()) return false;
  for (const std::size_t number : due_) {
    Way& way = ways_[number];
    const Constraint constraint = recallConstraintOf(way.from, way.to, way.mean);
    if (way.constraint == 0) {
      graph.addConstraint(constraint);
      way.constraint = graph.constraints().size();
    } else {
      graph.constraints()[static_cast<std::size_t>(way.constraint - 1)] = constraint;
      graph.reweighed();
    }
    way.told = way.mean.pose;
    while (way.tell_at <= way.passes) way.tell_at *= 2;
    way.due = false;
  }
  due_.clear();
  return true;
}

double PassEvidence::passes(std::uint32_t from, std::uint32_t to) const {
  const auto found = index_.find({from, to});
  return found == index_.end() ? 0.0 : ways_[found->second].passes;
}

void PassEvidence::save(State& state) const { state.set("ways", ways_); }

void PassEvidence::load(const State& state, const PoseGraph& graph) {
  state.get("ways", ways_);
  index_.clear();
  due_.clear();
  for (std::size_t k = 0; k < ways_.size(); ++k) {
    const Way& way = ways_[k];
    const std::size_t nodes = graph.nodes().size();
    if (way.from >= nodes || way.to >= nodes || way.from == way.to ||
        way.constraint > graph.constraints().size()) {
      throw std::runtime_error("state " + state.path() + "/ways: they do not fit the pose graph");
    }
    index_[{way.from, way.to}] = k;
    if (way.due) due_.insert(k);
  }
}

}  // namespace ratslam
