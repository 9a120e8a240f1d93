#include "ratslam/experience_map/solver/pose_graph_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "ratslam/common/state.h"
#include "ratslam/common/statistics.h"
#include "ratslam/experience_map/solver/rejoin.h"

namespace ratslam {
namespace {

/// Work of one update in block products: the least, and the most, for a recall that disagrees strongly with the
/// map. In between it grows with the square of the unusual disagreement. So visible errors are corrected soon,
/// and small ones cost little.
constexpr std::int64_t kLeastWork = 5000;
constexpr std::int64_t kGreatestWork = 400000;

/// Usual disagreement of a recall, which needs only the least work, and the disagreement that gets the most
/// work [exp_recall_sigma].
constexpr double kUsualDisagreement = 1.0;
constexpr double kStrongDisagreement = 5.0;

/// A step below this share of exp_recall_sigma ends the solver's iterations. If exp_recall_sigma is learned, the
/// smallest possible place [m] takes its role.
constexpr double kTolerance = 1e-7;
constexpr double kSmallestPlace = 0.1;

/// A stretch shorter than this share of exp_recall_sigma gets the uncertainty of one of this length.
constexpr double kShortestStretch = 0.01;

/// Least standard deviations of an odometry constraint: place [exp_recall_sigma], facing [rad], log-scale.
constexpr double kLeastError = 1e-3;
constexpr double kLeastTurnError = 1e-5;
constexpr double kLeastScaleError = 1e-6;

/// Systematic errors of an odometry, which the covariance of single steps leaves out, over a stretch of one
/// place: relative to its length (more for the height, because an error of the pitch persists), and of the facing
/// [rad] (0.2 degrees in 100 places).
constexpr double kSharedPlaceError = 0.01;
constexpr double kSharedHeightError = 0.012;
constexpr double kSharedTurnError = 3e-4;

/// Standard deviations of an unmeasured motion: place [exp_recall_sigma], facing [rad], log-scale. They are just
/// small enough to keep the system definite until a recall places the nodes beyond.
constexpr double kLostPlace = 1000.0;
constexpr double kLostFacing = 10.0;
constexpr double kLostScale = 1.0;

/// Width of a correction's kernel. A correction has four residuals, a recall mostly two: so its kernel is wider.
constexpr double kCorrectionDoubt = 2.0;

/// A node beside which the robot has been placed, in its saved form.
struct KnownNode {
  std::uint32_t node = 0;
  NodeCovariance covariance = NodeCovariance::Zero();

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("node", node);
    fields("covariance", covariance);
  }
};

}  // namespace

PoseGraphMap::PoseGraphMap(const ExperienceMapParams& params)
    : params_(params),
      pose_graph_(params.exp_recall_kernel),
      solver_(params.exp_scale, params.exp_height,
              kTolerance * (params.exp_recall_sigma > 0.0 ? params.exp_recall_sigma : kSmallestPlace)),
      spread_(params.exp_recall_sigma, params.exp_recall_facing_sigma) {}

MapPose PoseGraphMap::framePose(const ExperienceGraph&, std::uint32_t frame) const {
  return pose_graph_.nodes().at(frame);
}

RobotPlace PoseGraphMap::create(const ExperienceGraph& graph, const RobotPlace& robot,
                                const RecallGeometry* geometry) {
  if (!nodes_.empty() && !robot.lost) spread_.addSpacing(robot.motion.length);
  const std::uint32_t node =
      nodes_.empty() ? pose_graph_.addNode(graph.experiences().back().pose) : extendChain(robot);
  nodes_.push_back(node);
  recalls_.push_back(0);
  beside_.reset();
  TemplateOffset offset;
  if (geometry == nullptr || !geometry->measured()) {
    offset.displacement = Eigen::Vector2d(geometry != nullptr ? geometry->ahead : 0.0, 0.0);
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

std::optional<RobotPlace> PoseGraphMap::recall(const ExperienceGraph&, std::uint32_t experience,
                                               const RobotPlace& robot, double relative_rad,
                                               const RecallGeometry* geometry) {
  Constraint constraint = recallConstraint(experience, relative_rad, geometry);
  if (strayed(experience, constraint, robot)) return std::nullopt;
  if (onKnownGround(experience, constraint, robot)) return pass(constraint, robot);
  ++recalls_[experience];
  beside_.reset();
  constraint.to = extendChain(robot);
  if (constraint.vague) weighAfterLast(constraint);
  pose_graph_.addConstraint(constraint);
  recalled_ = true;
  if (rejoin(pose_graph_, constraint)) {
    solver_.abandon();
    pose_graph_.reweighed();
  }
  const auto& nodes = pose_graph_.nodes();
  disagreement_ = std::max(
      disagreement_, PoseGraph::residual(constraint, nodes[constraint.from], nodes[constraint.to]).norm());
  return RobotPlace{constraint.to, Motion{}};
}

RobotPlace PoseGraphMap::locate(std::uint32_t experience, double relative_rad,
                                const RecallGeometry* geometry) {
  const Constraint at = recallConstraint(experience, relative_rad, geometry);
  const double unit = pose_graph_.nodes()[at.from].scale();
  RobotPlace found{at.from, Motion{}};
  found.motion.pose = at.measured;
  found.motion.pose.x /= unit;
  found.motion.pose.y /= unit;
  const Eigen::Vector4d units(1.0 / unit, 1.0 / unit, 1.0 / unit, 1.0);
  found.motion.error.covariance = units.asDiagonal() * covarianceOf(at) * units.asDiagonal();
  beside_ = at.from;
  newest_covariance_ = covarianceAt(at.from);
  return found;
}

void PoseGraphMap::weighAfterLast(Constraint& recall) {
  const auto& nodes = pose_graph_.nodes();
  if (vague_recall_) {
    const MapPose& last = nodes[*vague_recall_];
    recall.apart = std::hypot(nodes[recall.to].x - last.x, nodes[recall.to].y - last.y);
  }
  vague_recall_ = recall.to;
  spread_.weigh(recall);
}

RobotPlace PoseGraphMap::anchor(const ExperienceGraph&, const RobotPlace& robot) {
  const RelativePose& pose = robot.motion.pose;
  const RelativePose& at = robot.standing.at;
  const bool still = pose.x == at.x && pose.y == at.y && pose.z == at.z && pose.yaw == at.yaw;
  // On known ground the next recall places the robot anew, whatever the motion was. Frames would only add up.
  if (nodes_.empty() || robot.lost || robot.standing.beside || still) return robot;
  return {extendChain(robot), Motion{}};
}

void PoseGraphMap::correct(ExperienceGraph& graph, const CorrectedWay& way) {
  auto& nodes = pose_graph_.nodes();
  const MapPose start = compose(nodes[way.from], way.before);
  std::map<std::uint32_t, MapPose> corrected{{way.from, nodes[way.from]}};
  for (const auto& [frame, pose] : way.frames) {
    corrected[frame] = compose(start, pose);
    corrected[frame].log_scale = nodes[frame].log_scale;
  }
  // The chain within the stretch follows the corrected path. Its constraints keep their weights; one more
  // constraint over the whole stretch carries the weight of the correction.
  for (Constraint& constraint : pose_graph_.constraints()) {
    const auto from = corrected.find(constraint.from);
    const auto to = corrected.find(constraint.to);
    if (constraint.closes() || from == corrected.end() || to == corrected.end()) continue;
    constraint.measured = between(from->second, to->second);
  }
  for (const auto& [frame, pose] : corrected) nodes[frame] = pose;
  graph.setPoses([this, &nodes](std::uint32_t id) { return nodes[nodes_[id]]; });
  if (way.frames.empty()) return;
  solver_.abandon();
  pose_graph_.reweighed();
  recalled_ = true;
  if (way.within == 0 || way.frames[way.within - 1].first == way.from) return;
  Constraint whole;
  whole.from = way.from;
  whole.to = way.frames[way.within - 1].first;
  whole.measured = between(nodes[whole.from], nodes[whole.to]);
  whole.shortcut = true;
  whole.doubt = kCorrectionDoubt;
  whole.scale_weight = 0.0;
  const Eigen::Matrix4d turned = turnedAxes(way.before.yaw);
  setWeights(whole, turned * way.covariance * turned.transpose());
  pose_graph_.addConstraint(whole);
}

void PoseGraphMap::setWeights(Constraint& constraint, const Eigen::Matrix4d& covariance) const {
  const double least = square(kLeastError * spread_.place());
  const Eigen::Vector4d bounds(least, least, least, square(kLeastTurnError));
  weigh(constraint, covariance + Eigen::Matrix4d(bounds.asDiagonal()));
}

std::uint32_t PoseGraphMap::extendChain(const RobotPlace& robot) {
  const MapPose& from = pose_graph_.nodes()[robot.frame];
  MapPose end = compose(from, robot.motion.pose);
  end.log_scale *= robot.motion.error.scale_kept;
  Constraint chain = chainConstraint(robot);
  newest_covariance_ = carried(chain, newest_covariance_);
  along_chain_.clear();
  chain.to = pose_graph_.addNode(end);
  pose_graph_.addConstraint(chain);
  return chain.to;
}

std::optional<Eigen::Matrix4d> PoseGraphMap::covariance(const RobotPlace& robot) const {
  if (nodes_.empty()) return std::nullopt;
  return poseCovariance(carried(chainConstraint(robot), newest_covariance_));
}

NodeCovariance PoseGraphMap::carried(const Constraint& constraint, const NodeCovariance& covariance) const {
  NodeCovariance end = PoseGraph::propagate(constraint, pose_graph_.nodes()[constraint.from], covariance);
  if (!params_.exp_scale) {  // the scale is no unknown
    end.row(3).setZero();
    end.col(3).setZero();
  }
  return end;
}

void PoseGraphMap::takeCovariance() {
  if (beside_) {
    if (const auto known = solver_.covarianceOf(*beside_)) newest_covariance_ = ground_[*beside_] = *known;
    return;
  }
  const auto known = solver_.newestCovariance();
  if (!known) return;
  newest_covariance_ = known->second;
  // Propagate along the chain that has been appended since. Where the robot left known ground, it begins at an older node.
  for (const Constraint& constraint : pose_graph_.constraints()) {
    if (constraint.closes() || constraint.to <= known->first) continue;
    if (constraint.from < known->first) newest_covariance_ = *solver_.covarianceOf(constraint.from);
    newest_covariance_ = carried(constraint, newest_covariance_);
  }
}

NodeCovariance PoseGraphMap::covarianceAt(std::uint32_t node) {
  if (const auto known = solver_.covarianceOf(node)) return *known;
  // Without a recall there is no optimum: errors add up along the chain.
  if (along_chain_.empty()) {
    along_chain_.assign(pose_graph_.nodes().size(), NodeCovariance::Zero());
    for (const Constraint& constraint : pose_graph_.constraints()) {
      if (constraint.closes()) continue;
      const auto known = solver_.covarianceOf(constraint.to);
      along_chain_[constraint.to] = known ? *known : carried(constraint, along_chain_[constraint.from]);
    }
  }
  return along_chain_[node];
}

Constraint PoseGraphMap::chainConstraint(const RobotPlace& robot) const {
  Constraint chain = drivenConstraint(robot);
  const Standing& standing = robot.standing;
  if (!standing.beside || robot.lost) return chain;
  const NodeCovariance spread = spreadBeside(robot, chain);
  setWeights(chain, poseCovariance(spread));
  chain.scale_weight = 1.0 / std::sqrt(1.0 / square(chain.scale_weight) + standing.covariance(3, 3) +
                                       square(standing.log_unit));
  return chain;
}

Constraint PoseGraphMap::drivenConstraint(const RobotPlace& robot) const {
  const MotionError& error = robot.motion.error;
  Constraint chain;
  chain.from = robot.frame;
  chain.measured = robot.motion.pose;
  // For a source without covariance the errors are random walks: variances grow with the path length.
  const double place = spread_.place();
  const auto stretches = [place](double length) {
    return std::sqrt(std::max(length / place, kShortestStretch));
  };
  if (error.said_length == 0.0 && error.covariance.isZero(0.0)) {
    const double unsaid = stretches(robot.motion.length);
    chain.xy_weight = Eigen::Matrix2d::Identity() / (params_.exp_odometry_sigma * place * unsaid);
    chain.z_weight = 1.0 / (params_.exp_odometry_sigma * place * unsaid);
    chain.yaw_weight = 1.0 / (params_.exp_rotation_sigma * unsaid);
  } else {
    // The covariance of single steps leaves out the errors that all steps share (lens, mounting, wheel).
    const double unsaid = std::max(robot.motion.length - error.said_length, 0.0) / place;
    const double shared = robot.motion.length / place;
    const auto variance = [&](double shared_error) {
      return place * place * (square(params_.exp_odometry_sigma) * unsaid + square(shared_error) * shared);
    };
    const Eigen::Vector4d beyond(
        variance(kSharedPlaceError), variance(kSharedPlaceError), variance(kSharedHeightError),
        square(params_.exp_rotation_sigma) * unsaid + square(kSharedTurnError) * shared);
    setWeights(chain, error.covariance + Eigen::Matrix4d(beyond.asDiagonal()));
  }
  chain.scale_kept = error.scale_kept;
  const double unsaid_way = std::max(robot.motion.length - error.said_scale_length, 0.0);
  const bool scale_said = error.said_scale_length > 0.0 || error.scale_variance > 0.0;
  const double unsaid_scale =
      params_.exp_scale_sigma * (scale_said ? std::sqrt(unsaid_way / place) : stretches(unsaid_way));
  chain.scale_weight = 1.0 / (scale_said ? std::sqrt(error.scale_variance + unsaid_scale * unsaid_scale +
                                                     kLeastScaleError * kLeastScaleError)
                                         : unsaid_scale);
  if (robot.lost) {
    chain.xy_weight = Eigen::Matrix2d::Identity() / (kLostPlace * place);
    chain.z_weight = 1.0 / (kLostPlace * place);
    chain.yaw_weight = 1.0 / kLostFacing;
    chain.scale_weight = 1.0 / kLostScale;
  }
  return chain;
}

void PoseGraphMap::update(ExperienceGraph& graph, RobotPlace&) {
  if (solver_.settled(pose_graph_) && evidence_.tell(pose_graph_)) recalled_ = true;
  if (recalled_) resume(graph);
  recalled_ = false;
}

void PoseGraphMap::resume(ExperienceGraph& graph) {
  const double share =
      std::clamp((disagreement_ - kUsualDisagreement) / (kStrongDisagreement - kUsualDisagreement), 0.0, 1.0);
  if (solver_.settled(pose_graph_)) return;
  work(graph, kLeastWork + static_cast<std::int64_t>(share * share * static_cast<double>(kGreatestWork)));
}

void PoseGraphMap::settle(ExperienceGraph& graph) {
  do {
    while (!solver_.complete(pose_graph_)) work(graph, std::numeric_limits<std::int64_t>::max());
  } while (learnSpread() || evidence_.tell(pose_graph_));
}

bool PoseGraphMap::learnSpread() {
  if (!spread_.learn(pose_graph_)) return false;
  for (Constraint& constraint : pose_graph_.constraints()) {
    if (constraint.vague) spread_.weigh(constraint);
  }
  pose_graph_.reweighed();
  return true;
}

void PoseGraphMap::save(State& state) const {
  pose_graph_.save(state.child("graph"));
  solver_.save(state.child("solver"));
  state.set("nodes", nodes_);
  state.set("offsets", offsets_);
  state.set("recalls", recalls_);
  evidence_.save(state.child("evidence"));
  std::vector<KnownNode> ground;
  for (const auto& [node, covariance] : ground_) ground.push_back({node, covariance});
  state.set("ground", ground);
  state.set("beside", beside_);
  state.set("strays", strays_);
  state.set("vague_recall", vague_recall_);
  state.set("spread", spread_);
  state.set("newest_covariance", newest_covariance_);
  state.set("recalled", recalled_);
  state.set("disagreement", disagreement_);
}

void PoseGraphMap::load(const State& state) {
  pose_graph_.load(state.child("graph"));
  solver_.load(state.child("solver"), pose_graph_);
  state.get("nodes", nodes_);
  state.get("offsets", offsets_);
  state.get("recalls", recalls_);
  evidence_.load(state.child("evidence"), pose_graph_);
  ground_.clear();
  for (const KnownNode& known : state.get<std::vector<KnownNode>>("ground")) {
    ground_[known.node] = known.covariance;
  }
  state.get("beside", beside_);
  state.get("strays", strays_);
  state.get("vague_recall", vague_recall_);
  state.get("spread", spread_);
  state.get("newest_covariance", newest_covariance_);
  state.get("recalled", recalled_);
  state.get("disagreement", disagreement_);
  const std::size_t frames = pose_graph_.nodes().size();
  if (offsets_.size() != nodes_.size() || recalls_.size() != nodes_.size() ||
      std::max(beside_.value_or(0), vague_recall_.value_or(0)) >= std::max<std::size_t>(frames, 1) ||
      std::any_of(nodes_.begin(), nodes_.end(), [frames](std::uint32_t node) { return node >= frames; })) {
    throw std::runtime_error("state " + state.path() + "/nodes: they do not fit the pose graph");
  }
}

void PoseGraphMap::work(ExperienceGraph& graph, std::int64_t amount) {
  if (!solver_.advance(pose_graph_, amount)) return;
  along_chain_.clear();
  // The size of the last step estimates the remaining distance from the optimum.
  disagreement_ = solver_.settled(pose_graph_) ? 0.0 : solver_.lastStep() / spread_.place();
  if (solver_.settled(pose_graph_)) {
    takeCovariance();
    learnSpread();
  }
  graph.setPoses([this](std::uint32_t id) { return pose_graph_.nodes()[nodes_[id]]; });
}

}  // namespace ratslam
