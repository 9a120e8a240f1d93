#include "ratslam/experience_map/solver/pose_graph_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ratslam/common/state.h"

namespace ratslam {
namespace {

/// Work of one update, in block products: at least, and where a recall disagrees strongly with the map. In
/// between it grows with the square of the disagreement beyond what recalls usually have, so that what is
/// visible is mended soon and the rest costs little.
constexpr std::int64_t kLeastWork = 5000;
constexpr std::int64_t kGreatestWork = 400000;

/// Disagreement, in exp_recall_sigma, up to which a recall says nothing new, and from which an update works
/// as much as it may.
constexpr double kUsualDisagreement = 1.0;
constexpr double kStrongDisagreement = 5.0;

/// Steps below this share of exp_recall_sigma end the solver's iterations.
constexpr double kTolerance = 1e-7;

/// A stretch as short as this share of exp_recall_sigma is as uncertain as one of this length.
constexpr double kShortestStretch = 0.01;

/// Share of exp_recall_sigma by which a measured direction leaves the place open across it, beside its own
/// error.
constexpr double kLateralShare = 0.1;

/// How little is known of a way that nobody measured: place [exp_recall_sigma], facing [rad], log-scale. Just
/// enough to hold what lies beyond it until a recall says where it is.
constexpr double kLostPlace = 1000.0;
constexpr double kLostFacing = 10.0;
constexpr double kLostScale = 1.0;

}  // namespace

PoseGraphMap::PoseGraphMap(const ExperienceMapParams& params)
    : params_(params),
      pose_graph_(params.exp_recall_kernel),
      solver_(params.exp_scale, params.exp_height, kTolerance * params.exp_recall_sigma) {}

MapPose PoseGraphMap::framePose(const ExperienceGraph&, std::uint32_t frame) const {
  return pose_graph_.nodes().at(frame);
}

RobotPlace PoseGraphMap::create(const ExperienceGraph& graph, const RobotPlace& robot,
                                const RecallGeometry* geometry) {
  const std::uint32_t node =
      nodes_.empty() ? pose_graph_.addNode(graph.experiences().back().pose) : extendChain(robot);
  nodes_.push_back(node);
  TemplateOffset offset;
  if (geometry == nullptr) {
    offset.displacement = Eigen::Vector2d::Zero();
  } else {
    offset.rotation = geometry->relative_rad;
    if (geometry->distance >= 0.0) {
      offset.displacement = geometry->distance * Eigen::Vector2d(std::cos(geometry->direction_rad),
                                                                 std::sin(geometry->direction_rad));
    }
  }
  offsets_.push_back(offset);
  return {node, Motion{}};
}

RobotPlace PoseGraphMap::recall(const ExperienceGraph&, std::uint32_t experience, const RobotPlace& robot,
                                double relative_rad, const RecallGeometry* geometry) {
  Constraint constraint = recallConstraint(experience, relative_rad, geometry);
  constraint.to = extendChain(robot);
  pose_graph_.addConstraint(constraint);
  recalled_ = true;
  const auto& nodes = pose_graph_.nodes();
  disagreement_ = std::max(
      disagreement_, PoseGraph::residual(constraint, nodes[constraint.from], nodes[constraint.to]).norm());
  return {constraint.to, Motion{}};
}

std::uint32_t PoseGraphMap::extendChain(const RobotPlace& robot) {
  Constraint chain;
  chain.from = robot.frame;
  chain.to = pose_graph_.addNode(compose(pose_graph_.nodes()[robot.frame], robot.motion.pose));
  chain.measured = robot.motion.pose;
  // Random walks: variances grow with the way driven.
  const double place = params_.exp_recall_sigma;
  const double stretches = std::sqrt(std::max(robot.motion.length / place, kShortestStretch));
  chain.xy_weight = Eigen::Matrix2d::Identity() / (params_.exp_odometry_sigma * place * stretches);
  chain.z_weight = 1.0 / (params_.exp_odometry_sigma * place * stretches);
  chain.yaw_weight = 1.0 / (params_.exp_rotation_sigma * stretches);
  chain.scale_weight = 1.0 / (params_.exp_scale_sigma * stretches);
  if (robot.lost) {
    chain.xy_weight = Eigen::Matrix2d::Identity() / (kLostPlace * place);
    chain.z_weight = 1.0 / (kLostPlace * place);
    chain.yaw_weight = 1.0 / kLostFacing;
    chain.scale_weight = 1.0 / kLostScale;
  }
  pose_graph_.addConstraint(chain);
  return chain.to;
}

Constraint PoseGraphMap::recallConstraint(std::uint32_t experience, double relative_rad,
                                          const RecallGeometry* geometry) const {
  const double place = params_.exp_recall_sigma;
  Constraint constraint;
  constraint.recall = true;
  constraint.from = nodes_[experience];
  constraint.measured.yaw = wrapAngle(relative_rad);
  constraint.xy_weight /= place;
  constraint.z_weight = 1.0 / place;
  constraint.yaw_weight = 1.0 / params_.exp_recall_facing_sigma;
  if (geometry == nullptr) return constraint;

  const TemplateOffset& offset = offsets_[experience];
  constraint.measured.yaw = wrapAngle(geometry->relative_rad - offset.rotation);
  constraint.yaw_weight = 1.0 / geometry->sigma_rotation;
  if (!offset.displacement) return constraint;

  // From the axes of the template to those of the experience.
  const Eigen::Rotation2Dd to_experience(-offset.rotation);
  const Eigen::Vector2d along =
      to_experience * Eigen::Vector2d(std::cos(geometry->direction_rad), std::sin(geometry->direction_rad));
  const Eigen::Vector2d across(-along.y(), along.x());
  const double distance = std::max(geometry->distance, 0.0);
  const Eigen::Vector2d measured = distance * along - to_experience * *offset.displacement;
  constraint.measured.x = measured.x();
  constraint.measured.y = measured.y();
  const bool measured_length = geometry->distance >= 0.0;
  const double sigma_along =
      measured_length ? std::hypot(kLateralShare * place, geometry->sigma_distance) : place;
  const double sigma_across =
      std::hypot(kLateralShare * place, (measured_length ? distance : place) * geometry->sigma_direction);
  constraint.xy_weight.row(0) = along / std::min(sigma_along, place);
  constraint.xy_weight.row(1) = across / std::min(sigma_across, place);
  return constraint;
}

void PoseGraphMap::update(ExperienceGraph& graph, RobotPlace&) {
  if (recalled_) resume(graph);
  recalled_ = false;
}

void PoseGraphMap::resume(ExperienceGraph& graph) {
  const double share =
      std::clamp((disagreement_ - kUsualDisagreement) / (kStrongDisagreement - kUsualDisagreement), 0.0, 1.0);
  work(graph, kLeastWork + static_cast<std::int64_t>(share * share * static_cast<double>(kGreatestWork)));
}

void PoseGraphMap::settle(ExperienceGraph& graph) {
  while (!solver_.settled(pose_graph_)) work(graph, std::numeric_limits<std::int64_t>::max());
}

void PoseGraphMap::save(State& state) const {
  pose_graph_.save(state.child("graph"));
  solver_.save(state.child("solver"));
  state.set("nodes", nodes_);
  state.set("offsets", offsets_);
  state.set("recalled", recalled_);
  state.set("disagreement", disagreement_);
}

void PoseGraphMap::load(const State& state) {
  pose_graph_.load(state.child("graph"));
  solver_.load(state.child("solver"), pose_graph_);
  state.get("nodes", nodes_);
  state.get("offsets", offsets_);
  state.get("recalled", recalled_);
  state.get("disagreement", disagreement_);
  const std::size_t frames = pose_graph_.nodes().size();
  if (offsets_.size() != nodes_.size() ||
      std::any_of(nodes_.begin(), nodes_.end(), [frames](std::uint32_t node) { return node >= frames; })) {
    throw std::runtime_error("state " + state.path() + "/nodes: they do not fit the pose graph");
  }
}

void PoseGraphMap::work(ExperienceGraph& graph, std::int64_t amount) {
  if (solver_.settled(pose_graph_)) return;
  if (!solver_.advance(pose_graph_, amount)) return;
  // What the last step moved tells how far the map was, and so about how far it still is, from the optimum.
  disagreement_ = solver_.settled(pose_graph_) ? 0.0 : solver_.lastStep() / params_.exp_recall_sigma;
  graph.setPoses([this](std::uint32_t id) { return pose_graph_.nodes()[nodes_[id]]; });
}

}  // namespace ratslam
