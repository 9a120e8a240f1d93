#include "ratslam/orb_odometry/bundle_adjustment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

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

/// An observation as poses and points predict it.
struct Prediction {
  Eigen::Vector3d point_in_camera;
  Reprojection reprojection;
  double normalised = 0.0;  // length of the error [sigma]
};

struct Evaluation {
  std::vector<Prediction> predictions;
  double cost = 0.0;
};

std::vector<Eigen::Matrix3d> rotationsOf(const std::vector<RigidTransform>& poses) {
  std::vector<Eigen::Matrix3d> rotations;
  rotations.reserve(poses.size());
  for (const RigidTransform& pose : poses) rotations.push_back(pose.rotation.toRotationMatrix());
  return rotations;
}

void evaluate(const CameraModel& camera, const std::vector<RigidTransform>& poses,
              const std::vector<Eigen::Vector3d>& points, const std::vector<BundleObservation>& observations,
              double huber, Evaluation& evaluation) {
  const std::vector<Eigen::Matrix3d> rotations = rotationsOf(poses);
  evaluation.predictions.resize(observations.size());
  evaluation.cost = 0.0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const BundleObservation& observation = observations[i];
    const auto pose = static_cast<std::size_t>(observation.pose);
    Prediction& prediction = evaluation.predictions[i];
    prediction.point_in_camera =
        rotations[pose] * points[static_cast<std::size_t>(observation.point)] + poses[pose].translation;
    prediction.reprojection = reproject(camera, prediction.point_in_camera, observation.pixel);
    prediction.normalised = prediction.reprojection.depth > 0.0
                                ? prediction.reprojection.error.norm() / observation.sigma
                                : kBehindCamera;
    evaluation.cost += huberCost(prediction.normalised, huber);
  }
}

/// Everything of the normal equations that does not depend on the damping.
struct Linearisation {
  std::vector<Matrix6> pose_hessian;
  std::vector<Vector6> pose_gradient;
  std::vector<Eigen::Matrix3d> point_hessian;
  std::vector<Eigen::Vector3d> point_gradient;
  std::vector<Matrix63> coupling;  // one an observation, zero for fixed poses
};

void linearise(const BundleProblem& problem, const Evaluation& evaluation, double huber,
               Linearisation& linear) {
  const auto poses = static_cast<std::size_t>(problem.free_poses);
  linear.pose_hessian.assign(poses, Matrix6::Zero());
  linear.pose_gradient.assign(poses, Vector6::Zero());
  linear.point_hessian.assign(problem.points.size(), Eigen::Matrix3d::Zero());
  linear.point_gradient.assign(problem.points.size(), Eigen::Vector3d::Zero());
  linear.coupling.resize(problem.observations.size());

  const std::vector<Eigen::Matrix3d> rotations = rotationsOf(problem.poses);
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& observation = problem.observations[i];
    const auto pose = static_cast<std::size_t>(observation.pose);
    const auto point = static_cast<std::size_t>(observation.point);
    const auto& [x, reprojection, normalised] = evaluation.predictions[i];
    linear.coupling[i].setZero();
    if (!(reprojection.depth > 0.0)) continue;
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
  const auto poses = static_cast<std::size_t>(problem.free_poses);
  std::vector<Matrix6> blocks(poses * poses, Matrix6::Zero());  // row by row, lower triangle only
  const Eigen::Index size = 6 * problem.free_poses;
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(size);
  for (std::size_t pose = 0; pose < poses; ++pose) {
    Matrix6& hessian = blocks[pose * poses + pose];
    hessian = linear.pose_hessian[pose];
    hessian.diagonal() *= 1.0 + damping;
    hessian.diagonal().array() += 1e-12;
    gradient.segment<6>(6 * static_cast<Eigen::Index>(pose)) = linear.pose_gradient[pose];
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
      const auto row = static_cast<std::size_t>(observations[a].pose);
      const Matrix63 product = linear.coupling[a] * inverse[point];
      gradient.segment<6>(6 * observations[a].pose).noalias() -= product * linear.point_gradient[point];
      for (std::size_t b = begin; b < end; ++b) {
        if (observations[b].pose > observations[a].pose) continue;
        const auto column = static_cast<std::size_t>(observations[b].pose);
        blocks[row * poses + column].noalias() -= product * linear.coupling[b].transpose();
      }
    }
    begin = end;
  }

  Eigen::MatrixXd reduced = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t row = 0; row < poses; ++row) {
    for (std::size_t column = 0; column <= row; ++column) {
      reduced.block<6, 6>(6 * static_cast<Eigen::Index>(row), 6 * static_cast<Eigen::Index>(column)) =
          blocks[row * poses + column];
    }
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
  Evaluation evaluation;
  evaluate(camera, problem.poses, problem.points, problem.observations, options.huber, evaluation);
  summary.initial_cost = summary.final_cost = evaluation.cost;
  if (problem.observations.empty()) return summary;

  Linearisation linear;
  Step step;
  Evaluation moved_evaluation;
  double damping = kFirstDamping;
  bool moved = true;
  while (summary.iterations < options.max_iterations && damping < kMostDamping) {
    ++summary.iterations;
    if (moved) linearise(problem, evaluation, options.huber, linear);
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
    evaluate(camera, poses, points, problem.observations, options.huber, moved_evaluation);
    if (!(moved_evaluation.cost < evaluation.cost)) {
      damping *= 10.0;
      continue;
    }
    const bool converged =
        evaluation.cost - moved_evaluation.cost < options.relative_decrease * evaluation.cost;
    problem.poses = std::move(poses);
    problem.points = std::move(points);
    std::swap(evaluation, moved_evaluation);
    damping = std::max(kLeastDamping, damping * 0.1);
    moved = true;
    if (converged) break;
  }
  summary.final_cost = evaluation.cost;
  return summary;
}

}  // namespace ratslam
