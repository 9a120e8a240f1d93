/// The weighted pose graph: poses with scale and height, and the constraints between them.
///
/// Nodes are poses (x, y, facing, lambda = log-scale, z). A constraint states the pose of node `to` in the frame
/// of node `from`. Its displacement m is in the odometry's unit if odometry measured it, else in the map's.
/// The weighted residuals of a constraint from i to j are:
///
///     e_facing = wrap(facing_j - facing_i - facing_ij)
///     r_xy     = W_xy (R(facing_i)^T (p_j - p_i) - exp(lambda_i) m_ij - g e_facing)
///     r_facing = w_r e_facing
///     r_lambda = w_s (lambda_j - kept lambda_i)               only where the odometry measured
///     r_z      = w_z (z_j - z_i - exp(lambda_i) dz_ij)
///
/// The energy is the sum of their squares. Recalls, and odometry's later corrections of unmeasured stretches,
/// pass through Cauchy's kernel c^2 log(1 + r^2 / c^2): so a wrong recall cannot fold the map, while a right one
/// within the odometry's uncertainty still closes the loop.
///
/// g is the regression of the displacement on the error of the facing: a robot that has turned further than measured
/// has also moved to that side. W_xy is the square root of the information of (x, y) for a known facing. With unit
/// weights, g = 0, lambda = 0 and no z this is the energy of equation (6). Node 0 is fixed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "ratslam/experience_map/map_pose.h"

namespace ratslam {

class State;

struct Constraint {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  RelativePose measured;
  /// W_xy: square root of the information of (x, y) for a known facing, in the axes of `from`.
  Eigen::Matrix2d xy_weight = Eigen::Matrix2d::Identity();
  Eigen::Vector2d xy_by_yaw = Eigen::Vector2d::Zero();  ///< g: displacement per error of the facing [m/rad]
  double yaw_weight = 1.0;                              ///< 1 / standard deviation, like the next two
  double scale_weight = 1.0;
  double z_weight = 1.0;
  double scale_kept = 1.0;  ///< factor from the log-scale of `from` to its part at `to`
  bool recall = false;      ///< a recall: no information about scale, in the map's unit, may be wrong
  bool vague = false;  ///< a recall without image geometry: it states only that the places are about the same
  /// Of a vague recall, the distance from the recall before it [m]; the largest number if there is none before.
  double apart = std::numeric_limits<double>::max();
  double doubt = 1.0;     ///< width of this constraint's kernel, in units of the graph's
  bool shortcut = false;  ///< later odometry over a stretch that the chain of constraints also covers

  /// Whether the constraint closes a loop, and so can disagree with earlier constraints.
  bool closes() const { return recall || shortcut; }

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("from", from);
    fields("to", to);
    fields("measured", measured);
    fields("xy_weight", xy_weight);
    fields("xy_by_yaw", xy_by_yaw);
    fields("yaw_weight", yaw_weight);
    fields("scale_weight", scale_weight);
    fields("z_weight", z_weight);
    fields("scale_kept", scale_kept);
    fields("recall", recall);
    fields("vague", vague);
    fields("apart", apart);
    fields("doubt", doubt);
    fields("shortcut", shortcut);
  }
};

/// Covariance of a node (x, y, facing, log-scale, z) relative to node 0.
using NodeCovariance = Eigen::Matrix<double, 5, 5>;
using Residual = Eigen::Matrix<double, 5, 1>;          ///< weighted: along, across, facing, log-scale, height
using ResidualJacobian = Eigen::Matrix<double, 5, 5>;  ///< by (x, y, facing, log-scale, z) of a node

/// Covariance of the measured (x, y, z, yaw) of a constraint, in the axes of `from`.
Eigen::Matrix4d covarianceOf(const Constraint& constraint);

/// Sets the weights of a constraint from a covariance of its (x, y, z, yaw). The error of the height is taken to be
/// independent of the others. @param covariance  with a positive diagonal. If it is not positive definite, place and
/// facing are taken to be independent
void weigh(Constraint& constraint, const Eigen::Matrix4d& covariance);

/// The part of a node's covariance that is of (x, y, z, yaw), in that order.
Eigen::Matrix4d poseCovariance(const NodeCovariance& covariance);
/// Adds an independent error of (x, y, z, yaw).
void addPoseCovariance(NodeCovariance& covariance, const Eigen::Matrix4d& pose);

struct LinearisedConstraint {
  Residual residual;
  ResidualJacobian by_from;
  ResidualJacobian by_to;
};

class PoseGraph {
 public:
  /// @param kernel width c of Cauchy's kernel, in standard deviations.
  explicit PoseGraph(double kernel) : kernel_(kernel) {}

  const std::vector<MapPose>& nodes() const { return nodes_; }
  std::vector<MapPose>& nodes() { return nodes_; }
  const std::vector<Constraint>& constraints() const { return constraints_; }
  /// For changing weights. Call reweighed() after a change.
  std::vector<Constraint>& constraints() { return constraints_; }
  /// Counts the changes after which the nodes may no longer be at the optimum.
  std::size_t evidence() const { return evidence_; }
  void reweighed() { ++evidence_; }

  std::uint32_t addNode(const MapPose& pose);

  /// @throws std::invalid_argument if an end does not exist or both ends are the same.
  void addConstraint(const Constraint& constraint);

  static Residual residual(const Constraint& constraint, const MapPose& from, const MapPose& to);
  static LinearisedConstraint linearise(const Constraint& constraint, const MapPose& from, const MapPose& to);

  /// Covariance of the node `to` of a constraint that odometry made, given that of `from`.
  static NodeCovariance propagate(const Constraint& constraint, const MapPose& from,
                                  const NodeCovariance& covariance);

  /// A constraint's share of the energy, given its squared residual.
  double energy(const Constraint& constraint, double squared) const;

  /// Derivative of energy() by the squared residual: the constraint's weight in a reweighted least-squares
  /// step.
  double weight(const Constraint& constraint, double squared) const;

  /// Energy of the graph with its nodes at `nodes`. @param first constraint to count. @param sum energy of the
  /// constraints before it.
  double energy(const std::vector<MapPose>& nodes, std::size_t first = 0, double sum = 0.0) const;

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit
  void load(const State& state);

 private:
  double kernel_;
  std::vector<MapPose> nodes_;
  std::vector<Constraint> constraints_;
  std::uint64_t evidence_ = 0;
};

}  // namespace ratslam
