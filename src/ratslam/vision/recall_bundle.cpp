#include "ratslam/vision/recall_bundle.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "ratslam/vision/rigid_transform.h"

namespace ratslam {
namespace {

constexpr int kRounds = 3;       // of refinement and gating
constexpr int kIterations = 8;   // per round
constexpr double kCauchy = 2.0;  // [sigma]
constexpr double kGate = 4.0;    // [sigma]
// Least scale of the residuals, in expected sigmas: positions are discrete.
constexpr double kMinSigma = 0.05;
constexpr double kMinZ = 1e-3;     // least z of R b + rho t for a point in front of the view
constexpr double kWeakest = 1e-9;  // less information on an inverse depth counts as none

// Two views of six parameters: a fixed bound on sizes avoids allocations.
constexpr int kMaxSize = 12;
using Block = Eigen::Matrix<double, 2, 6>;
using Basis = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 6>;
using SquareMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxSize, kMaxSize>;
using PoseVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxSize, 1>;
using PoseRow = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMaxSize>;
using PointRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Basis of the free directions of a view's pose, as columns over (rotation, translation).
Basis freedom(const RecallView& view) {
  const int dofs = view.motion == RecallMotion::kRotation ? 3 : view.motion == RecallMotion::kUnit ? 5 : 6;
  Basis basis = Basis::Zero(6, dofs);
  basis.topLeftCorner<3, 3>().setIdentity();
  if (view.motion == RecallMotion::kFree) basis.bottomRightCorner<3, 3>().setIdentity();
  if (view.motion == RecallMotion::kUnit) {
    const Eigen::Vector3d u = view.t.unitOrthogonal();
    basis.block<3, 1>(3, 3) = u;
    basis.block<3, 1>(3, 4) = view.t.cross(u).normalized();
  }
  return basis;
}

struct Residual {
  bool visible = false;
  Eigen::Vector2d error = Eigen::Vector2d::Zero();  // [sigma]
  Block by_pose = Block::Zero();                    // derivative
  Eigen::Vector2d by_depth = Eigen::Vector2d::Zero();
};

Residual residual(const RecallView& view, const RecallPoint& point, const RecallObservation& seen) {
  Residual r;
  const Eigen::Vector3d turned = view.R * point.bearing.homogeneous();
  const Eigen::Vector3d m = turned + point.inverse_depth * view.t;
  if (m.z() < kMinZ) return r;
  r.visible = true;
  const Eigen::Vector2d at = m.hnormalized();
  r.error = (at - seen.bearing) / seen.sigma;
  Eigen::Matrix<double, 2, 3> by_m;
  by_m << 1.0, 0.0, -at.x(), 0.0, 1.0, -at.y();
  by_m /= m.z() * seen.sigma;
  r.by_pose.leftCols<3>() = -by_m * skew(turned);
  r.by_pose.rightCols<3>() = by_m * point.inverse_depth;
  r.by_depth = by_m * view.t;
  return r;
}

/// Normal equations with the points eliminated.
struct ReducedSystem {
  SquareMatrix hessian;  // over the free pose parameters
  PoseVector gradient;
  PointRows coupling;  // one row per point: d2 / d(point) d(poses)
  Eigen::VectorXd point_hessian;
  Eigen::VectorXd point_gradient;
  double cost = 0.0;
};

class Problem {
 public:
  explicit Problem(RecallBundle& bundle) : bundle_(bundle) {}

  double cost() const {
    double sum = 0.0;
    for (const RecallObservation& seen : bundle_.observations) {
      if (seen.inlier) sum += lossOf(evaluate(seen));
    }
    return sum;
  }

  /// @param robust Cauchy weights instead of equal ones
  ReducedSystem linearise(bool robust) {
    bases_.clear();
    offsets_.clear();
    int size = 0;
    for (const RecallView& view : bundle_.views) {
      bases_.push_back(freedom(view));
      offsets_.push_back(size);
      size += static_cast<int>(bases_.back().cols());
    }
    const auto points = static_cast<Eigen::Index>(bundle_.points.size());
    ReducedSystem s{SquareMatrix::Zero(size, size), PoseVector::Zero(size), PointRows::Zero(points, size),
                    Eigen::VectorXd::Zero(points), Eigen::VectorXd::Zero(points)};
    for (const RecallObservation& seen : bundle_.observations) {
      if (!seen.inlier) continue;
      const Residual r = evaluate(seen);
      s.cost += lossOf(r);
      if (!r.visible) continue;
      const double weight = robust ? 1.0 / (1.0 + r.error.squaredNorm() / (kCauchy * kCauchy)) : 1.0;
      const auto v = static_cast<std::size_t>(seen.view);
      const Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, 6> by_pose = r.by_pose * bases_[v];
      const Eigen::Index width = by_pose.cols();
      s.hessian.block(offsets_[v], offsets_[v], width, width) += weight * by_pose.transpose() * by_pose;
      s.gradient.segment(offsets_[v], width) += weight * by_pose.transpose() * r.error;
      s.coupling.block(seen.point, offsets_[v], 1, width) += weight * r.by_depth.transpose() * by_pose;
      s.point_hessian[seen.point] += weight * r.by_depth.squaredNorm();
      s.point_gradient[seen.point] += weight * r.by_depth.dot(r.error);
    }
    return s;
  }

  /// Step of the poses, with the points eliminated. @param damping relative to the diagonal (Marquardt)
  PoseVector solve(const ReducedSystem& s, double damping, Eigen::VectorXd& point_step) const {
    SquareMatrix reduced = s.hessian;
    reduced.diagonal() *= 1.0 + damping;
    PoseVector gradient = s.gradient;
    const Eigen::VectorXd information = damped(s, damping);
    for (Eigen::Index i = 0; i < information.size(); ++i) {
      const PoseRow row = s.coupling.row(i) / information[i];
      reduced.noalias() -= s.coupling.row(i).transpose() * row;
      gradient.noalias() -= row.transpose() * s.point_gradient[i];
    }
    PoseVector step = -reduced.ldlt().solve(gradient);
    point_step = -(s.point_gradient + s.coupling * step).cwiseQuotient(information);
    return step;
  }

  void move(const PoseVector& step, const Eigen::VectorXd& point_step) {
    for (std::size_t v = 0; v < bundle_.views.size(); ++v) {
      RecallView& view = bundle_.views[v];
      const Eigen::Matrix<double, 6, 1> d = bases_[v] * step.segment(offsets_[v], bases_[v].cols());
      const Eigen::Vector3d turn = d.head<3>();
      const double angle = turn.norm();
      const Eigen::Vector3d axis = angle > 0.0 ? Eigen::Vector3d(turn / angle) : Eigen::Vector3d::UnitX();
      view.R = (Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)) * Eigen::Quaterniond(view.R))
                   .normalized()
                   .toRotationMatrix();
      view.t += d.tail<3>();
      if (view.motion == RecallMotion::kUnit) view.t.normalize();
    }
    for (std::size_t i = 0; i < bundle_.points.size(); ++i) {
      bundle_.points[i].inverse_depth += point_step[static_cast<Eigen::Index>(i)];
    }
  }

  void iterate() {
    double damping = 1e-4;
    for (int i = 0; i < kIterations; ++i) {
      const ReducedSystem system = linearise(true);
      Eigen::VectorXd point_step;
      const PoseVector step = solve(system, damping, point_step);
      const std::vector<RecallView> views = bundle_.views;
      const std::vector<RecallPoint> points = bundle_.points;
      if (step.allFinite() && point_step.allFinite()) move(step, point_step);
      const double now = cost();
      if (!(now < system.cost)) {
        bundle_.views = views;
        bundle_.points = points;
        damping *= 30.0;
        if (damping > 1e4) return;
        continue;
      }
      damping = std::max(1e-9, damping * 0.1);
      if (system.cost - now < 1e-6 * system.cost) return;
    }
  }

  void gate() {
    for (RecallObservation& seen : bundle_.observations) {
      const Residual r = evaluate(seen);
      const RecallPoint& point = bundle_.points[static_cast<std::size_t>(seen.point)];
      const double depth_sigma = 1.0 / std::max(r.by_depth.norm(), 1e-12);
      seen.inlier = r.visible && r.error.norm() < kGate && point.inverse_depth > -kGate * depth_sigma;
    }
  }

  /// Sets the sigma of each point's inverse depth; infinite if the observations do not determine it.
  void pointSigmas(const ReducedSystem& s) {
    for (std::size_t i = 0; i < bundle_.points.size(); ++i) {
      const double information = s.point_hessian[static_cast<Eigen::Index>(i)];
      bundle_.points[i].sigma =
          information > kWeakest ? 1.0 / std::sqrt(information) : std::numeric_limits<double>::infinity();
    }
  }

  std::optional<Eigen::MatrixXd> covariance(const ReducedSystem& s) const {
    const Eigen::Index size = s.gradient.size();
    SquareMatrix reduced = s.hessian;
    const Eigen::VectorXd information = damped(s, 0.0);
    double freedoms = -static_cast<double>(size);
    double squares = 0.0;
    for (Eigen::Index i = 0; i < information.size(); ++i) {
      reduced.noalias() -= s.coupling.row(i).transpose() * (s.coupling.row(i) / information[i]);
      if (s.point_hessian[i] > kWeakest) freedoms -= 1.0;
    }
    for (const RecallObservation& seen : bundle_.observations) {
      if (!seen.inlier) continue;
      freedoms += 2.0;
      squares += evaluate(seen).error.squaredNorm();
    }
    const Eigen::LDLT<SquareMatrix> solver(reduced);
    if (freedoms < 1.0 || !(solver.vectorD().minCoeff() > 0.0)) return std::nullopt;
    const double variance = std::max(squares / freedoms, kMinSigma * kMinSigma);
    const SquareMatrix minimal = variance * solver.solve(SquareMatrix::Identity(size, size));
    if (!minimal.allFinite()) return std::nullopt;

    const auto views = static_cast<Eigen::Index>(bundle_.views.size());
    Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(6 * views, size);
    for (std::size_t v = 0; v < bases_.size(); ++v) {
      spread.block(6 * static_cast<Eigen::Index>(v), offsets_[v], 6, bases_[v].cols()) = bases_[v];
    }
    return Eigen::MatrixXd(spread * minimal * spread.transpose());
  }

 private:
  Residual evaluate(const RecallObservation& seen) const {
    return residual(bundle_.views[static_cast<std::size_t>(seen.view)],
                    bundle_.points[static_cast<std::size_t>(seen.point)], seen);
  }
  /// Cauchy's loss. A point behind a view costs as much as an error far beyond the gate.
  static double lossOf(const Residual& r) {
    const double squared = r.visible ? r.error.squaredNorm() : 1e6;
    return kCauchy * kCauchy * std::log1p(squared / (kCauchy * kCauchy));
  }
  static Eigen::VectorXd damped(const ReducedSystem& s, double damping) {
    return (s.point_hessian * (1.0 + damping)).cwiseMax(kWeakest);
  }

  RecallBundle& bundle_;
  std::vector<Basis> bases_;  // at the last linearisation
  std::vector<int> offsets_;
};

}  // namespace

double inverseDepth(const RecallView& view, const Eigen::Vector2d& anchor, const Eigen::Vector2d& bearing) {
  const Eigen::Vector3d turned = view.R * anchor.homogeneous();
  // (turned + rho t).xy = bearing (turned + rho t).z, two equations linear in rho.
  const Eigen::Vector2d by_depth = view.t.head<2>() - bearing * view.t.z();
  const Eigen::Vector2d constant = turned.head<2>() - bearing * turned.z();
  const double information = by_depth.squaredNorm();
  return information > 1e-12 ? std::max(0.0, -by_depth.dot(constant) / information) : 0.0;
}

std::optional<Eigen::MatrixXd> refineRecallBundle(RecallBundle& bundle) {
  Problem problem(bundle);
  for (int round = 0; round < kRounds; ++round) {
    problem.iterate();
    problem.gate();
  }
  const ReducedSystem system = problem.linearise(false);
  problem.pointSigmas(system);
  return problem.covariance(system);
}

int inlierCount(const RecallBundle& bundle, int view) {
  return static_cast<int>(
      std::count_if(bundle.observations.begin(), bundle.observations.end(),
                    [view](const RecallObservation& seen) { return seen.inlier && seen.view == view; }));
}

}  // namespace ratslam
