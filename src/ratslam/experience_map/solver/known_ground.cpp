// Recalls on known ground (pose_graph_map.h): they place the robot and add evidence, but no node.
#include <cmath>

#include "ratslam/experience_map/solver/pose_graph_map.h"

namespace ratslam {
namespace {

/// Number of recalls of an experience that make nodes, before it counts as known ground.
constexpr std::uint32_t kRecallsWithNodes = 2;

/// A recall agrees with the map if the kernel leaves it at least this share of its weight.
constexpr double kAgrees = 0.5;

/// Bound on nodes per experience. Beyond it a recall that disagrees makes no node either: it places the robot
/// until the next recall.
constexpr std::size_t kMostNodes = 8;

/// Bound on relative poses per experience in PassEvidence. Beyond it passes only add to known ones.
constexpr std::size_t kMostWays = 4;

/// Variance of a prediction that is not used, in units of a recall's variance.
constexpr double kWorthless = 1e6;

MapPose unscaled(const MapPose& pose) { return {pose.x, pose.y, pose.z, pose.yaw, 0.0}; }

/// Halves the information of a recall: each recall is used twice, by the pass before it and by the pass after.
UncertainPose half(UncertainPose seen) {
  seen.covariance *= 2.0;
  return seen;
}

}  // namespace

bool PoseGraphMap::onKnownGround(std::uint32_t experience, const Constraint& recall,
                                 const RobotPlace& robot) const {
  if (robot.lost || recalls_[experience] < kRecallsWithNodes) return false;
  return agrees(recall, robot) || pose_graph_.nodes().size() >= kMostNodes * nodes_.size();
}

bool PoseGraphMap::agrees(const Constraint& recall, const RobotPlace& robot) const {
  const auto& nodes = pose_graph_.nodes();
  const MapPose end = compose(nodes[robot.frame], robot.motion.pose);
  const double squared = PoseGraph::residual(recall, nodes[recall.from], end).squaredNorm();
  return pose_graph_.weight(recall, squared) >= kAgrees;
}

bool PoseGraphMap::strayed(std::uint32_t experience, const Constraint& recall, const RobotPlace& robot) {
  if (!robot.standing.beside || robot.lost || recalls_[experience] < kRecallsWithNodes ||
      agrees(recall, robot)) {
    strays_ = 0;
    return false;
  }
  return ++strays_ == 1;
}

RobotPlace PoseGraphMap::pass(const Constraint& recall, const RobotPlace& robot) {
  const MapPose& there = pose_graph_.nodes()[recall.from];
  const UncertainPose seen{recall.measured, covarianceOf(recall)};
  const bool agreed = agrees(recall, robot);
  Prediction prediction;
  if (agreed) {
    prediction = predicted(robot, there);
  } else {
    prediction.pose = seen.pose;
    prediction.log_scale = there.log_scale;
    prediction.covariance.diagonal().setConstant(kWorthless * seen.covariance.trace());
    if (!params_.exp_scale) prediction.covariance(3, 3) = 0.0;
  }
  const NodeCovariance reached = carried(chainConstraint(robot), newest_covariance_);
  NodeCovariance& known = ground_.try_emplace(recall.from, reached).first->second;
  if (reached.trace() < known.trace()) known = reached;
  newest_covariance_ = known;
  beside_ = recall.from;
  RobotPlace place;
  place.frame = recall.from;
  place.standing = stand(prediction, seen, there.log_scale);
  place.standing.way_from = recall.from;
  place.standing.way = half(seen);
  if (agreed) goOn(place.standing, recall.from, seen, robot);
  place.motion.pose = place.standing.at;
  return place;
}

NodeCovariance PoseGraphMap::spreadBeside(const RobotPlace& robot, const Constraint& driven) const {
  const Standing& standing = robot.standing;
  const double scale = pose_graph_.nodes()[robot.frame].scale();
  const double dx = scale * (robot.motion.pose.x - standing.at.x);
  const double dy = scale * (robot.motion.pose.y - standing.at.y);
  NodeCovariance by_begin = NodeCovariance::Identity();
  by_begin(0, 2) = -dy;
  by_begin(1, 2) = dx;
  by_begin(0, 3) = dx;
  by_begin(1, 3) = dy;
  by_begin(4, 3) = scale * (robot.motion.pose.z - standing.at.z);
  by_begin(3, 3) = driven.scale_kept;
  NodeCovariance spread = by_begin * standing.covariance * by_begin.transpose();
  addPoseCovariance(spread, covarianceOf(driven));
  spread(3, 3) += 1.0 / (driven.scale_weight * driven.scale_weight);
  if (!params_.exp_scale) {  // the scale is no unknown
    spread.row(3).setZero();
    spread.col(3).setZero();
  }
  return spread;
}

Prediction PoseGraphMap::predicted(const RobotPlace& robot, const MapPose& place) const {
  const MapPose& frame = pose_graph_.nodes()[robot.frame];
  const Constraint driven = drivenConstraint(robot);
  Prediction prediction;
  prediction.pose = between(unscaled(place), compose(frame, robot.motion.pose));
  prediction.log_scale = driven.scale_kept * (frame.log_scale + robot.standing.log_unit);
  NodeCovariance turn = NodeCovariance::Identity();
  turn.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(frame.yaw - place.yaw).toRotationMatrix();
  prediction.covariance = turn * spreadBeside(robot, driven) * turn.transpose();
  return prediction;
}

void PoseGraphMap::goOn(Standing& standing, std::uint32_t to, const UncertainPose& seen,
                        const RobotPlace& robot) {
  const UncertainPose driven = drivenWay(robot);
  if (!robot.standing.beside) {
    // The pass began at a node that no other pass begins at, so it is a constraint of its own.
    if (robot.frame == to) return;
    pose_graph_.addConstraint(recallConstraintOf(to, robot.frame, joined(half(seen), inverted(driven))));
    recalled_ = true;
    return;
  }
  const UncertainPose way = joined(robot.standing.way, driven);
  const std::uint32_t from = robot.standing.way_from;
  const auto spread = [](const UncertainPose& pose) { return pose.covariance(0, 0) + pose.covariance(1, 1); };
  const double likely = 2.0 * spread(seen);  // both recalls, at the start and at the end
  const bool known = evidence_.passes(from, to) > 0.0;
  if (from == to || spread(way) < (known ? 1.0 : 1.5) * likely) {
    standing.way_from = from;
    standing.way = way;
    return;
  }
  if (!known && evidence_.ways() >= kMostWays * nodes_.size()) return;
  evidence_.add(from, to, joined(way, inverted(half(seen))));
}

UncertainPose PoseGraphMap::drivenWay(const RobotPlace& robot) const {
  const RelativePose& at = robot.standing.at;
  const RelativePose& end = robot.motion.pose;
  const double scale = pose_graph_.nodes()[robot.frame].scale();
  UncertainPose driven{between({at.x, at.y, at.z, at.yaw, 0.0}, {end.x, end.y, end.z, end.yaw, 0.0}),
                       covarianceOf(drivenConstraint(robot))};
  driven.pose.x *= scale;
  driven.pose.y *= scale;
  driven.pose.z *= scale;
  const Eigen::Matrix4d turn = turnedAxes(-at.yaw);
  driven.covariance = (turn * driven.covariance * turn.transpose()).eval();
  return driven;
}

}  // namespace ratslam
