#include "ratslam/experience_map/solver/pose_graph.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <stdexcept>
#include <string>

#include "ratslam/common/state.h"
#include "ratslam/experience_map/solver/uncertain_pose.h"

namespace ratslam {
namespace {

constexpr int kPose[] = {0, 1, 4, 2};  // of (x, y, z, yaw) among (x, y, facing, log-scale, z)

/// Displacement from one node to another in the axes of the first, and the scale of its measurement.
struct Displacement {
  double cos, sin;  ///< of the facing of the first
  double x, y;
  double scale;
};

Displacement displacement(const Constraint& constraint, const MapPose& from, const MapPose& to) {
  Displacement d{};
  d.cos = std::cos(from.yaw);
  d.sin = std::sin(from.yaw);
  const double dx = to.x - from.x;
  const double dy = to.y - from.y;
  d.x = d.cos * dx + d.sin * dy;
  d.y = -d.sin * dx + d.cos * dy;
  d.scale = constraint.recall ? 1.0 : from.scale();
  return d;
}

Residual residualOf(const Constraint& constraint, const Displacement& d, const MapPose& from,
                    const MapPose& to) {
  const RelativePose& m = constraint.measured;
  const Eigen::Matrix2d& w = constraint.xy_weight;
  const double turned = wrapAngle(to.yaw - from.yaw - m.yaw);
  const double ex = d.x - d.scale * m.x - constraint.xy_by_yaw.x() * turned;
  const double ey = d.y - d.scale * m.y - constraint.xy_by_yaw.y() * turned;
  Residual r;
  r[0] = w(0, 0) * ex + w(0, 1) * ey;
  r[1] = w(1, 0) * ex + w(1, 1) * ey;
  r[2] = constraint.yaw_weight * turned;
  r[3] = constraint.recall
             ? 0.0
             : constraint.scale_weight * (to.log_scale - constraint.scale_kept * from.log_scale);
  r[4] = constraint.z_weight * (to.z - from.z - d.scale * m.z);
  return r;
}

}  // namespace

Eigen::Matrix4d covarianceOf(const Constraint& constraint) {
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  const Eigen::Matrix2d& weight = constraint.xy_weight;
  const double yaw = 1.0 / (constraint.yaw_weight * constraint.yaw_weight);
  const Eigen::Vector2d& by_yaw = constraint.xy_by_yaw;
  covariance.topLeftCorner<2, 2>() =
      (weight.transpose() * weight).inverse() + yaw * by_yaw * by_yaw.transpose();
  covariance.topRightCorner<2, 1>() = yaw * by_yaw;
  covariance.bottomLeftCorner<1, 2>() = yaw * by_yaw.transpose();
  covariance(2, 2) = 1.0 / (constraint.z_weight * constraint.z_weight);
  covariance(3, 3) = yaw;
  return covariance;
}

void weigh(Constraint& constraint, const Eigen::Matrix4d& covariance) {
  const double yaw = covariance(3, 3);
  const Eigen::Matrix2d xy = covariance.topLeftCorner<2, 2>();
  const Eigen::Vector2d shared = covariance.topRightCorner<2, 1>();
  Eigen::LLT<Eigen::Matrix2d> of_place(xy - shared * shared.transpose() / yaw);
  constraint.xy_by_yaw = shared / yaw;
  if (of_place.info() != Eigen::Success) {  // the covariance is not positive definite
    of_place.compute(xy);
    constraint.xy_by_yaw.setZero();
  }
  constraint.xy_weight = of_place.matrixL().solve(Eigen::Matrix2d::Identity());
  constraint.z_weight = 1.0 / std::sqrt(covariance(2, 2));
  constraint.yaw_weight = 1.0 / std::sqrt(yaw);
}

Eigen::Matrix4d poseCovariance(const NodeCovariance& covariance) {
  Eigen::Matrix4d pose;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) pose(row, column) = covariance(kPose[row], kPose[column]);
  }
  return pose;
}

void addPoseCovariance(NodeCovariance& covariance, const Eigen::Matrix4d& pose) {
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) covariance(kPose[row], kPose[column]) += pose(row, column);
  }
}

std::uint32_t PoseGraph::addNode(const MapPose& pose) {
  nodes_.push_back(pose);
  return static_cast<std::uint32_t>(nodes_.size() - 1);
}

void PoseGraph::addConstraint(const Constraint& constraint) {
  if (constraint.from >= nodes_.size() || constraint.to >= nodes_.size() ||
      constraint.from == constraint.to) {
    throw std::invalid_argument("constraint from node " + std::to_string(constraint.from) + " to " +
                                std::to_string(constraint.to) + ": it must join two of the " +
                                std::to_string(nodes_.size()) + " nodes");
  }
  constraints_.push_back(constraint);
  if (constraint.closes()) ++evidence_;
}

Residual PoseGraph::residual(const Constraint& constraint, const MapPose& from, const MapPose& to) {
  return residualOf(constraint, displacement(constraint, from, to), from, to);
}

LinearisedConstraint PoseGraph::linearise(const Constraint& constraint, const MapPose& from,
                                          const MapPose& to) {
  const Displacement d = displacement(constraint, from, to);
  LinearisedConstraint linear;
  linear.residual = residualOf(constraint, d, from, to);
  linear.by_from.setZero();
  linear.by_to.setZero();

  Eigen::Matrix2d to_axes;
  to_axes << d.cos, d.sin, -d.sin, d.cos;
  const Eigen::Matrix2d by_place = constraint.xy_weight * to_axes;
  linear.by_to.topLeftCorner<2, 2>() = by_place;
  linear.by_from.topLeftCorner<2, 2>() = -by_place;
  const Eigen::Vector2d& by_yaw = constraint.xy_by_yaw;
  linear.by_to.block<2, 1>(0, 2) = -(constraint.xy_weight * by_yaw);
  linear.by_from.block<2, 1>(0, 2) = constraint.xy_weight * (Eigen::Vector2d(d.y, -d.x) + by_yaw);
  linear.by_to(2, 2) = constraint.yaw_weight;
  linear.by_from(2, 2) = -constraint.yaw_weight;
  linear.by_to(4, 4) = constraint.z_weight;
  linear.by_from(4, 4) = -constraint.z_weight;
  if (!constraint.recall) {
    const RelativePose& m = constraint.measured;
    linear.by_from.block<2, 1>(0, 3) = constraint.xy_weight * Eigen::Vector2d(-d.scale * m.x, -d.scale * m.y);
    linear.by_to(3, 3) = constraint.scale_weight;
    linear.by_from(3, 3) = -constraint.scale_weight * constraint.scale_kept;
    linear.by_from(4, 3) = -constraint.z_weight * d.scale * m.z;
  }
  return linear;
}

NodeCovariance PoseGraph::propagate(const Constraint& constraint, const MapPose& from,
                                    const NodeCovariance& covariance) {
  const MapPose end = compose(from, constraint.measured);
  const double dx = end.x - from.x;
  const double dy = end.y - from.y;
  NodeCovariance by_from = NodeCovariance::Identity();
  by_from(0, 2) = -dy;
  by_from(1, 2) = dx;
  by_from(0, 3) = dx;
  by_from(1, 3) = dy;
  by_from(4, 3) = end.z - from.z;
  by_from(3, 3) = constraint.scale_kept;
  const Eigen::Matrix4d by_axes = turnedAxes(from.yaw);
  const Eigen::Matrix4d own = by_axes * covarianceOf(constraint) * by_axes.transpose();
  NodeCovariance result = by_from * covariance * by_from.transpose();
  addPoseCovariance(result, own);
  result(3, 3) += 1.0 / (constraint.scale_weight * constraint.scale_weight);
  return result;
}

double PoseGraph::energy(const Constraint& constraint, double squared) const {
  const double width = kernel_ * constraint.doubt;
  return constraint.closes() ? width * width * std::log1p(squared / (width * width)) : squared;
}

double PoseGraph::weight(const Constraint& constraint, double squared) const {
  const double width = kernel_ * constraint.doubt;
  return constraint.closes() ? 1.0 / (1.0 + squared / (width * width)) : 1.0;
}

double PoseGraph::energy(const std::vector<MapPose>& nodes, std::size_t first, double sum) const {
  for (std::size_t k = first; k < constraints_.size(); ++k) {
    const Constraint& constraint = constraints_[k];
    sum +=
        energy(constraint, residual(constraint, nodes[constraint.from], nodes[constraint.to]).squaredNorm());
  }
  return sum;
}

void PoseGraph::save(State& state) const {
  state.set("nodes", nodes_);
  state.set("constraints", constraints_);
  state.set("evidence", evidence_);
}

void PoseGraph::load(const State& state) {
  PoseGraph loaded(kernel_);
  state.get("nodes", loaded.nodes_);
  try {
    for (const Constraint& constraint : state.get<std::vector<Constraint>>("constraints")) {
      loaded.addConstraint(constraint);
    }
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error("state " + state.path() + ": " + error.what());
  }
  state.get("evidence", loaded.evidence_);
  *this = std::move(loaded);
}

}  // namespace ratslam
