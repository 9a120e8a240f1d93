/// The weighted graph behind a map that carries scale and height.
///
/// Nodes are poses (x, y, facing, lambda = log-scale, z). A constraint says where node `to` lies in the frame
/// of node `from`; with m its displacement (in the odometry's unit where the odometry measured it, in the
/// map's otherwise):
///
///     r_xy     = W_xy (R(facing_i)^T (p_j - p_i) - exp(lambda_i) m_ij)
///     r_facing = w_r wrap(facing_j - facing_i - facing_ij)
///     r_lambda = w_s (lambda_j - kept lambda_i)               only where the odometry measured
///     r_z      = w_z (z_j - z_i - exp(lambda_i) dz_ij)
///
/// The energy is the sum of squares; the share of a recall, and of what an odometry says afterwards of a
/// stretch that it did not measure, is passed through Cauchy's kernel c^2 log(1 + r^2 / c^2), so that a wrong
/// one cannot fold the map, while one that the odometry's uncertainty leaves possible still closes. With unit weights, lambda = 0 and z absent this is equation (6)'s energy. Node 0 is fixed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ratslam/experience_map/map_pose.h"

namespace ratslam {

class State;

struct Constraint {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  RelativePose measured;
  Eigen::Matrix2d xy_weight =
      Eigen::Matrix2d::Identity();  ///< square root of the information, in the axes of `from`
  double yaw_weight = 1.0;          ///< 1 / standard deviation
  double scale_weight = 1.0;
  double z_weight = 1.0;
  double scale_kept = 1.0;  ///< share of the log-scale of `from` that is left at `to`
  bool recall = false;      ///< says nothing about scale, is measured in the map's unit, and may be wrong
  bool vague = false;       ///< a recall of which only the place is known: the same one, more or less
  double doubt = 1.0;       ///< of what has a kernel: its width in units of the graph's
  bool shortcut = false;    ///< odometry over a stretch that the chain of constraints tells, too

  /// Whether it can disagree with the constraints before it.
  bool closes() const { return recall || shortcut; }

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("from", from);
    fields("to", to);
    fields("measured", measured);
    fields("xy_weight", xy_weight);
    fields("yaw_weight", yaw_weight);
    fields("scale_weight", scale_weight);
    fields("z_weight", z_weight);
    fields("scale_kept", scale_kept);
    fields("recall", recall);
    fields("vague", vague);
    fields("doubt", doubt);
    fields("shortcut", shortcut);
  }
};

/// Of a node (x, y, facing, log-scale, z) in the map, node 0 being exact.
using NodeCovariance = Eigen::Matrix<double, 5, 5>;
using Residual = Eigen::Matrix<double, 5, 1>;          ///< weighted: along, across, facing, log-scale, height
using ResidualJacobian = Eigen::Matrix<double, 5, 5>;  ///< by (x, y, facing, log-scale, z) of a node

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
  /// To weigh constraints anew; whoever does says so with reweighed().
  std::vector<Constraint>& constraints() { return constraints_; }
  /// Grows with every change that may leave the nodes away from the optimum.
  std::size_t evidence() const { return evidence_; }
  void reweighed() { ++evidence_; }

  std::uint32_t addNode(const MapPose& pose);

  /// @throws std::invalid_argument where an end does not exist or both ends are the same.
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

  /// Energy of the graph with its nodes at `nodes`. @param first constraint that counts; @param sum of those
  /// before it.
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
