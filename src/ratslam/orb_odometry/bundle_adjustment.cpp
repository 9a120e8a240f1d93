#include "ratslam/orb_odometry/bundle_adjustment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "ratslam/common/params.h"
#include "ratslam/orb_odometry/pose_refinement.h"

namespace ratslam {
namespace {

using Matrix63 = Eigen::Matrix<double, 6, 3>;

constexpr double kFirstDamping = 1e-5;
constexpr double kLeastDamping = 1e-9;
constexpr double kMostDamping = 1e6;
// What a point behind its camera costs: like an error of this many deviations, so that no step hides one
// there.
constexpr double kBehindCamera = 100.0;

double huberCost(double normalised, double threshold) {
  return normalised <= threshold ? 0.5 * normalised * normalised : threshold * (normalised - 0.5 * threshold);
}

double totalCost(const CameraModel& camera, const std::vector<RigidTransform>& poses,
                 const std::vector<Eigen::Vector3d>& points,
                 const std::vector<BundleObservation>& observations, double huber) {
  double cost = 0.0;
  for (const BundleObservation& observation : observations) {
    const Eigen::Vector3d x = poses[static_cast<std::size_t>(observation.pose)] *
                              points[static_cast<std::size_t>(observation.point)];
    const Reprojection reprojection = reproject(camera, x, observation.pixel);
    const bool visible = reprojection.depth > 0.0;
    cost += huberCost(visible ? reprojection.error.norm() / observation.sigma : kBehindCamera, huber);
  }
  return cost;
}

/// Everything of the normal equations that does not depend on the damping.
struct Linearisation {
  std::vector<Matrix6> pose_hessian;
  std::vector<Vector6> pose_gradient;
  std::vector<Eigen::Matrix3d> point_hessian;
  std::vector<Eigen::Vector3d> point_gradient;
  std::vector<Matrix63> coupling;  // one an observation, zero for fixed poses
};

void linearise(const CameraModel& camera, const BundleProblem& problem, double huber, Linearisation& linear) {
  const auto poses = static_cast<std::size_t>(problem.free_poses);
  linear.pose_hessian.assign(poses, Matrix6::Zero());
  linear.pose_gradient.assign(poses, Vector6::Zero());
  linear.point_hessian.assign(problem.points.size(), Eigen::Matrix3d::Zero());
  linear.point_gradient.assign(problem.points.size(), Eigen::Vector3d::Zero());
  linear.coupling.resize(problem.observations.size());

  std::vector<Eigen::Matrix3d> rotations;
  rotations.reserve(problem.poses.size());
  for (const RigidTransform& pose : problem.poses) rotations.push_back(pose.rotation.toRotationMatrix());

  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& observation = problem.observations[i];
    const auto pose = static_cast<std::size_t>(observation.pose);
    const auto point = static_cast<std::size_t>(observation.point);
    linear.coupling[i].setZero();
    const Eigen::Vector3d x = rotations[pose] * problem.points[point] + problem.poses[pose].translation;
    const Reprojection reprojection = reproject(camera, x, observation.pixel);
    if (!(reprojection.depth > 0.0)) continue;
    const double normalised = reprojection.error.norm() / observation.sigma;
    const double weight =
        (normalised > huber ? huber / normalised : 1.0) / (observation.sigma * observation.sigma);
    const Eigen::Matrix<double, 2, 3> by_point = reprojection.by_point_in_camera * rotations[pose];
    const Eigen::Matrix<double, 3, 2> weighted = weight * by_point.transpose();
    linear.point_hessian[point].noalias() += weighted * by_point;
    linear.point_gradient[point].noalias() += weighted * reprojection.error;
    if (observation.pose >= problem.free_poses) continue;
    const Eigen::Matrix<double, 2, 6> by_pose = reprojection.byPose(x);
    const Eigen::Matrix<double, 6, 2> weighted_pose = weight * by_pose.transpose();
    linear.pose_hessian[pose].noalias() += weighted_pose * by_pose;
    linear.pose_gradient[pose].noalias() += weighted_pose * reprojection.error;
    linear.coupling[i].noalias() = weighted_pose * by_point;
  }
}

struct Step {
  Eigen::VectorXd poses;
  std::vector<Eigen::Vector3d> points;
};

/// Solves the damped normal equations: reduced system of the poses, then each point by itself.
bool solveStep(const BundleProblem& problem, const Linearisation& linear, double damping, Step& step) {
  const Eigen::Index size = 6 * problem.free_poses;
  Eigen::MatrixXd reduced = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
  for (int pose = 0; pose < problem.free_poses; ++pose) {
    Matrix6 hessian = linear.pose_hessian[static_cast<std::size_t>(pose)];
    hessian.diagonal() *= 1.0 + damping;
    hessian.diagonal().array() += 1e-12;
    reduced.block<6, 6>(6 * pose, 6 * pose) = hessian;
    gradient.segment<6>(6 * pose) = linear.pose_gradient[static_cast<std::size_t>(pose)];
  }

  std::vector<Eigen::Matrix3d> inverse(problem.points.size(), Eigen::Matrix3d::Zero());
  const auto& observations = problem.observations;
  std::size_t begin = 0;
  while (begin < observations.size()) {
    const auto point = static_cast<std::size_t>(observations[begin].point);
    std::size_t end = begin;
    while (end < observations.size() && observations[end].point == observations[begin].point) ++end;
    Eigen::Matrix3d hessian = linear.point_hessian[point];
    hessian.diagonal() *= 1.0 + damping;
    hessian.diagonal().array() += 1e-12;
    inverse[point] = hessian.inverse();
    for (std::size_t a = begin; a < end; ++a) {
      if (observations[a].pose >= problem.free_poses) continue;
      const Eigen::Index row = 6 * observations[a].pose;
      const Matrix63 product = linear.coupling[a] * inverse[point];
      gradient.segment<6>(row).noalias() -= product * linear.point_gradient[point];
      for (std::size_t b = begin; b < end; ++b) {
        const Eigen::Index column = 6 * observations[b].pose;
        if (observations[b].pose >= problem.free_poses || column > row) continue;  // lower triangle only
        reduced.block<6, 6>(row, column).noalias() -= product * linear.coupling[b].transpose();
      }
    }
    begin = end;
  }

  const Eigen::LDLT<Eigen::MatrixXd, Eigen::Lower> factor(reduced);
  step.poses = -factor.solve(gradient);
  if (factor.info() != Eigen::Success || !step.poses.allFinite()) return false;

  step.points.assign(problem.points.size(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const auto point = static_cast<std::size_t>(observations[i].point);
    if (observations[i].pose >= problem.free_poses) continue;
    step.points[point].noalias() -=
        linear.coupling[i].transpose() * step.poses.segment<6>(6 * observations[i].pose);
  }
  for (std::size_t point = 0; point < step.points.size(); ++point) {
    step.points[point] = inverse[point] * (step.points[point] - linear.point_gradient[point]).eval();
  }
  return true;
}

void checkProblem(const BundleProblem& problem) {
  const auto poses = static_cast<int>(problem.poses.size());
  if (problem.free_poses < 0 || problem.free_poses > poses) {
    throwBadValue("free_poses", problem.free_poses, "it must not exceed the number of poses");
  }
  int last_point = 0;
  for (const BundleObservation& observation : problem.observations) {
    if (observation.pose < 0 || observation.pose >= poses) {
      throwBadValue("observation.pose", observation.pose, "there is no such pose");
    }
    if (observation.point < last_point || observation.point >= static_cast<int>(problem.points.size())) {
      throwBadValue("observation.point", observation.point, "points must exist and come in ascending order");
    }
    last_point = observation.point;
  }
}

}  // namespace

BundleSummary adjustBundle(const CameraModel& camera, BundleProblem& problem, const BundleOptions& options) {
  checkProblem(problem);
  BundleSummary summary;
  double cost = totalCost(camera, problem.poses, problem.points, problem.observations, options.huber);
  summary.initial_cost = summary.final_cost = cost;
  if (problem.observations.empty()) return summary;

  Linearisation linear;
  Step step;
  double damping = kFirstDamping;
  bool moved = true;
  while (summary.iterations < options.max_iterations && damping < kMostDamping) {
    ++summary.iterations;
    if (moved) linearise(camera, problem, options.huber, linear);
    moved = false;
    if (!solveStep(problem, linear, damping, step)) {
      damping *= 10.0;
      continue;
    }
    std::vector<RigidTransform> poses = problem.poses;
    for (int pose = 0; pose < problem.free_poses; ++pose) {
      RigidTransform& T = poses[static_cast<std::size_t>(pose)];
      T = expTransform(step.poses.segment<6>(6 * pose)) * T;
    }
    std::vector<Eigen::Vector3d> points = problem.points;
    for (std::size_t point = 0; point < points.size(); ++point) points[point] += step.points[point];
    const double new_cost = totalCost(camera, poses, points, problem.observations, options.huber);
    if (!(new_cost < cost)) {
      damping *= 10.0;
      continue;
    }
    const bool converged = cost - new_cost < options.relative_decrease * cost;
    problem.poses = std::move(poses);
    problem.points = std::move(points);
    cost = new_cost;
    damping = std::max(kLeastDamping, damping * 0.1);
    moved = true;
    if (converged) break;
  }
  summary.final_cost = cost;
  return summary;
}

}  // namespace ratslam
