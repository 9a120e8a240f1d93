#include "ratslam/orb_odometry/lens_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace ratslam {
namespace {

constexpr std::size_t kLeastViews = 3;     // of a landmark: two views fit any lens
constexpr double kUnitOfLength = 1e-6;     // relative damping: the scale of poses and points is free
constexpr double kLeastDeterminant = 0.3;  // of the lens's derivative at the corners: it must not fold
constexpr double kNegligibleShift = 0.02;  // [px]

using Jacobian23 = Eigen::Matrix<double, 2, 3>;
using Coupling = Eigen::Matrix<double, 6, 3>;

/// Derivative of a reprojection error by the lens's first two radial coefficients.
class LensJacobian {
 public:
  explicit LensJacobian(const CameraModel& camera)
      : camera_(camera), changed_{camera.withRadialChange({1.0, 0.0}), camera.withRadialChange({0.0, 1.0})} {}

  /// Raw pixels stay where they are: what the lens adds to a distorted pixel the undistorted one gives way.
  Eigen::Matrix2d at(const Eigen::Vector2d& pixel) const {
    const auto [raw, jacobian] = camera_.distortWithJacobian(pixel);
    Eigen::Matrix2d by_coefficient;  // lens models are linear in them
    for (int i = 0; i < 2; ++i)
      by_coefficient.col(i) = changed_[static_cast<std::size_t>(i)].distort(pixel) - raw;
    return jacobian.inverse() * by_coefficient;
  }

 private:
  const CameraModel& camera_;
  std::array<CameraModel, 2> changed_;
};

/// Normal equations over all poses (6 each) and the two coefficients, points eliminated one by one.
class ReducedEquations {
 public:
  explicit ReducedEquations(std::size_t poses)
      : lens_(6 * static_cast<Eigen::Index>(poses)),
        hessian_(Eigen::MatrixXd::Zero(lens_ + 2, lens_ + 2)),
        gradient_(Eigen::VectorXd::Zero(lens_ + 2)) {}

  void add(int pose, const Eigen::Matrix<double, 2, 6>& by_pose, const Jacobian23& by_point,
           const Eigen::Matrix2d& by_lens, const Eigen::Vector2d& error, double weight) {
    const Eigen::Index at = 6 * pose;
    hessian_.block<6, 6>(at, at) += weight * by_pose.transpose() * by_pose;
    hessian_.block<6, 2>(at, lens_) += weight * by_pose.transpose() * by_lens;
    hessian_.block<2, 2>(lens_, lens_) += weight * by_lens.transpose() * by_lens;
    gradient_.segment<6>(at) += weight * by_pose.transpose() * error;
    gradient_.segment<2>(lens_) += weight * by_lens.transpose() * error;
    point_hessian_ += weight * by_point.transpose() * by_point;
    point_gradient_ += weight * by_point.transpose() * error;
    point_lens_ += weight * by_lens.transpose() * by_point;
    point_poses_.emplace_back(at, weight * by_pose.transpose() * by_point);
  }

  void eliminatePoint() {
    const Eigen::Matrix3d inverse = point_hessian_.inverse();
    if (inverse.allFinite()) {
      for (const auto& [a, coupling_a] : point_poses_) {
        const Coupling scaled = coupling_a * inverse;
        for (const auto& [b, coupling_b] : point_poses_)
          hessian_.block<6, 6>(a, b) -= scaled * coupling_b.transpose();
        hessian_.block<6, 2>(a, lens_) -= scaled * point_lens_.transpose();
        gradient_.segment<6>(a) -= scaled * point_gradient_;
      }
      hessian_.block<2, 2>(lens_, lens_) -= point_lens_ * inverse * point_lens_.transpose();
      gradient_.segment<2>(lens_) -= point_lens_ * inverse * point_gradient_;
    }
    point_hessian_.setZero();
    point_gradient_.setZero();
    point_lens_.setZero();
    point_poses_.clear();
  }

  /// Eliminates all poses but the first, which holds the others.
  LensInformation eliminatePoses() const {
    const Eigen::Index free = lens_ - 6;
    Eigen::MatrixXd poses = hessian_.block(6, 6, free, free);
    poses.diagonal() *= 1.0 + kUnitOfLength;
    const Eigen::LDLT<Eigen::MatrixXd> factor(poses);
    const Eigen::MatrixXd coupling = hessian_.block(6, lens_, free, 2);
    const Eigen::MatrixXd solved = factor.solve(coupling);
    LensInformation information;
    information.hessian = hessian_.block<2, 2>(lens_, lens_) - coupling.transpose() * solved;
    information.gradient = gradient_.segment<2>(lens_) - solved.transpose() * gradient_.segment(6, free);
    return information;
  }

 private:
  Eigen::Index lens_;  // first row of the coefficients
  Eigen::MatrixXd hessian_;
  Eigen::VectorXd gradient_;
  Eigen::Matrix3d point_hessian_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d point_gradient_ = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 2, 3> point_lens_ = Eigen::Matrix<double, 2, 3>::Zero();
  std::vector<std::pair<Eigen::Index, Coupling>> point_poses_;
};

/// The whole local map, its observations weighted by how well they fit.
BundleProblem problemOf(const CameraModel& camera, const LocalMap& map, const RobustLoss& loss) {
  BundleProblem problem;
  const KeyframeId first = map.keyframes().front().id;
  for (const Keyframe& keyframe : map.keyframes()) problem.poses.push_back(keyframe.frame->T_camera_world);
  problem.free_poses = static_cast<int>(problem.poses.size());
  std::vector<double> errors;
  for (const Landmark& landmark : map.landmarks()) {
    if (landmark.observations.size() < kLeastViews) continue;
    for (const LandmarkObservation& seen : landmark.observations) {
      problem.observations.push_back(
          {seen.keyframe - first, static_cast<int>(problem.points.size()), seen.pixel, seen.sigma});
      const RigidTransform& pose = problem.poses[static_cast<std::size_t>(seen.keyframe - first)];
      const Reprojection reprojection = reproject(camera, pose * landmark.position, seen.pixel);
      if (reprojection.depth > 0.0) errors.push_back(reprojection.error.norm() / seen.sigma);
    }
    problem.points.push_back(landmark.position);
  }
  const double sigma = std::max(loss.min_sigma, robustSigma(std::move(errors)));
  for (BundleObservation& observation : problem.observations) observation.sigma *= sigma;
  return problem;
}

}  // namespace

LensInformation measureLens(const CameraModel& camera, const BundleProblem& problem, const RobustLoss& loss) {
  if (problem.poses.size() < 2) return {};
  const LensJacobian lens(camera);
  ReducedEquations equations(problem.poses.size());
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& observation = problem.observations[i];
    const RigidTransform& pose = problem.poses[static_cast<std::size_t>(observation.pose)];
    const Eigen::Vector3d x = pose * problem.points[static_cast<std::size_t>(observation.point)];
    const Reprojection reprojection = reproject(camera, x, observation.pixel);
    const double normalised = reprojection.error.norm() / observation.sigma;
    if (reprojection.depth > 0.0 && normalised * normalised <= loss.gate) {
      const double weight = std::min(1.0, loss.huber / normalised) / (observation.sigma * observation.sigma);
      equations.add(observation.pose, reprojection.byPose(x),
                    reprojection.byPoint(pose.rotation.toRotationMatrix()), lens.at(observation.pixel),
                    reprojection.error, weight);
    }
    const bool last =
        i + 1 == problem.observations.size() || problem.observations[i + 1].point != observation.point;
    if (last) equations.eliminatePoint();
  }
  return equations.eliminatePoses();
}

std::optional<CameraModel> LensRefinement::update(const CameraModel& camera, const LocalMap& map,
                                                  const RobustLoss& loss) {
  const KeyframeId newest = map.keyframes().back().id;
  if (map.full() && (!measured_ || map.keyframes().front().id > *measured_)) {
    const LensInformation found = measureLens(camera, problemOf(camera, map, loss), loss);
    information_ += found.hessian / params_.correlated;
    weighted_ += (found.hessian * applied_ - found.gradient) / params_.correlated;
    measured_ = newest;
  }
  const Eigen::Vector2d wanted = estimate();
  worthwhile_ = worthwhile_ || cornerShift(Eigen::Vector2d::Zero(), wanted) > params_.worthwhile_shift;
  const double shift = cornerShift(applied_, wanted);
  if (!worthwhile_ || shift < kNegligibleShift) return std::nullopt;
  const Eigen::Vector2d next =
      applied_ + std::min(1.0, params_.shift_a_keyframe / shift) * (wanted - applied_);
  const CameraModel better = calibrated_.withRadialChange(next);
  for (const double u : {0.0, camera.width - 1.0}) {
    for (const double v : {0.0, camera.height - 1.0}) {
      if (!(better.distortWithJacobian({u, v}).jacobian.determinant() > kLeastDeterminant))
        return std::nullopt;
    }
  }
  applied_ = next;
  return better;
}

Eigen::Vector2d LensRefinement::estimate() const {
  const double prior = 1.0 / (params_.prior_sigma * params_.prior_sigma);
  return (information_ + prior * Eigen::Matrix2d::Identity()).ldlt().solve(weighted_);
}

double LensRefinement::cornerShift(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
  const CameraModel before = calibrated_.withRadialChange(from);
  const CameraModel after = calibrated_.withRadialChange(to);
  double shift = 0.0;
  for (const double u : {0.0, calibrated_.width - 1.0}) {
    for (const double v : {0.0, calibrated_.height - 1.0})
      shift = std::max(shift, (after.distort({u, v}) - before.distort({u, v})).norm());
  }
  return shift;
}

}  // namespace ratslam
