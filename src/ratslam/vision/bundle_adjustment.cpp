#include "ratslam/vision/bundle_adjustment.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "ratslam/common/params.h"
#include "ratslam/simd/schur_kernels.h"
#include "ratslam/vision/pose_refinement.h"

namespace ratslam {
namespace {

/// The used rows of a padded column-major array.
template <int Columns>
using Padded = Eigen::Map<Eigen::Matrix<double, 6, Columns>, 0, Eigen::OuterStride<kSchurRows>>;
template <int Columns>
using ConstPadded = Eigen::Map<const Eigen::Matrix<double, 6, Columns>, 0, Eigen::OuterStride<kSchurRows>>;

const SchurKernels& kernels = schurKernels();

constexpr double kFirstDamping = 1e-5;
constexpr double kLeastDamping = 1e-9;
constexpr double kMostDamping = 1e6;
// Cost of a point behind its camera, as an error in standard deviations: so no step can hide a point there.
constexpr double kBehindCamera = 100.0;

double huberCost(double normalised, double threshold) {
  return normalised <= threshold ? 0.5 * normalised * normalised : threshold * (normalised - 0.5 * threshold);
}

/// Prediction of an observation from poses and points.
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

/// The parts of the normal equations that do not depend on the damping.
struct Linearisation {
  std::vector<Matrix6> pose_hessian;
  std::vector<Vector6> pose_gradient;
  std::vector<Eigen::Matrix3d> point_hessian;
  std::vector<Eigen::Vector3d> point_gradient;
  std::vector<FreeView> views;  // observations by free poses, grouped by point
  std::vector<int> first_view;  // of each point; the last entry is the end
};

void linearise(const BundleProblem& problem, const Evaluation& evaluation, double huber,
               Linearisation& linear) {
  const auto poses = static_cast<std::size_t>(problem.free_poses);
  linear.pose_hessian.assign(poses, Matrix6::Zero());
  linear.pose_gradient.assign(poses, Vector6::Zero());
  linear.point_hessian.assign(problem.points.size(), Eigen::Matrix3d::Zero());
  linear.point_gradient.assign(problem.points.size(), Eigen::Vector3d::Zero());
  linear.views.clear();
  linear.views.reserve(problem.observations.size());
  linear.first_view.assign(1, 0);

  const std::vector<Eigen::Matrix3d> rotations = rotationsOf(problem.poses);
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& observation = problem.observations[i];
    const auto pose = static_cast<std::size_t>(observation.pose);
    const auto point = static_cast<std::size_t>(observation.point);
    const auto& [x, reprojection, normalised] = evaluation.predictions[i];
    while (linear.first_view.size() <= point)
      linear.first_view.push_back(static_cast<int>(linear.views.size()));
    if (!(reprojection.depth > 0.0)) continue;
    const double weight =
        (normalised > huber ? huber / normalised : 1.0) / (observation.sigma * observation.sigma);
    const Eigen::Matrix<double, 2, 3> by_point = reprojection.byPoint(rotations[pose]);
    const Eigen::Matrix<double, 3, 2> weighted = weight * by_point.transpose();
    linear.point_hessian[point].noalias() += weighted * by_point;
    linear.point_gradient[point].noalias() += weighted * reprojection.error;
    if (observation.pose >= problem.free_poses) continue;
    const Eigen::Matrix<double, 2, 6> by_pose = reprojection.byPose(x);
    const Eigen::Matrix<double, 6, 2> weighted_pose = weight * by_pose.transpose();
    linear.pose_hessian[pose].noalias() += weighted_pose * by_pose;
    linear.pose_gradient[pose].noalias() += weighted_pose * reprojection.error;
    linear.views.emplace_back();
    linear.views.back().pose = observation.pose;
    Padded<3>(linear.views.back().coupling[0]).noalias() = weighted_pose * by_point;
  }
  linear.first_view.resize(problem.points.size() + 1, static_cast<int>(linear.views.size()));
}

struct Step {
  Eigen::VectorXd poses;
  std::vector<Eigen::Vector3d> points;
};

/// Levenberg-Marquardt damping of the diagonal.
template <class Matrix>
void damp(Matrix&& hessian, double damping) {
  hessian.diagonal() *= 1.0 + damping;
  hessian.diagonal().array() += 1e-12;
}

/// Solves the damped normal equations: first the reduced system of the poses, then each point on its own.
bool solveStep(const BundleProblem& problem, const Linearisation& linear, double damping, Step& step) {
  const int poses = problem.free_poses;
  std::vector<PoseEquations> equations(static_cast<std::size_t>(poses * poses));  // lower triangle only
  for (int pose = 0; pose < poses; ++pose) {
    PoseEquations& diagonal = equations[static_cast<std::size_t>(pose * poses + pose)];
    Padded<6>(diagonal.hessian[0]) = linear.pose_hessian[static_cast<std::size_t>(pose)];
    Padded<1>(diagonal.gradient) = linear.pose_gradient[static_cast<std::size_t>(pose)];
    damp(Padded<6>(diagonal.hessian[0]), damping);
  }
  std::vector<Eigen::Matrix3d> inverse(problem.points.size());
  for (std::size_t point = 0; point < inverse.size(); ++point) {
    Eigen::Matrix3d hessian = linear.point_hessian[point];
    damp(hessian, damping);
    inverse[point] = hessian.inverse();
    const int first = linear.first_view[point];
    const int views = linear.first_view[point + 1] - first;
    if (views == 0) continue;
    PointEquations own;
    Eigen::Map<Eigen::Matrix3d>(own.inverse[0]) = inverse[point];  // symmetric
    Eigen::Map<Eigen::Vector3d>(own.gradient) = linear.point_gradient[point];
    kernels.eliminatePoint(linear.views.data() + first, views, own, poses, equations.data());
  }

  const Eigen::Index size = 6 * static_cast<Eigen::Index>(poses);
  Eigen::MatrixXd reduced = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd gradient(size);
  for (int row = 0; row < poses; ++row) {
    for (int column = 0; column <= row; ++column) {
      const PoseEquations& block = equations[static_cast<std::size_t>(row * poses + column)];
      reduced.block<6, 6>(6 * row, 6 * column) = ConstPadded<6>(block.hessian[0]);
      if (row == column) gradient.segment<6>(6 * row) = ConstPadded<1>(block.gradient);
    }
  }
  const Eigen::LDLT<Eigen::MatrixXd, Eigen::Lower> factor(reduced);
  step.poses = -factor.solve(gradient);
  if (factor.info() != Eigen::Success || !step.poses.allFinite()) return false;

  step.points.resize(problem.points.size());
  for (std::size_t point = 0; point < step.points.size(); ++point) {
    Eigen::Vector3d right = -linear.point_gradient[point];
    for (int i = linear.first_view[point]; i < linear.first_view[point + 1]; ++i) {
      const FreeView& view = linear.views[static_cast<std::size_t>(i)];
      right.noalias() -= ConstPadded<3>(view.coupling[0]).transpose() * step.poses.segment<6>(6 * view.pose);
    }
    step.points[point].noalias() = inverse[point] * right;
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
