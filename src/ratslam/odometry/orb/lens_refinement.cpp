#include "ratslam/odometry/orb/lens_refinement.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace ratslam {
namespace {

constexpr std::size_t kLeastViews = 3;     // of a landmark, because two views fit any lens
constexpr double kUnitOfLength = 1e-6;     // relative damping, because the scale of poses and points is free
constexpr double kLeastDeterminant = 0.3;  // of the lens's derivative at the corners: the image must not fold
constexpr double kNegligibleShift = 0.02;  // [px]
constexpr double kNothingKnown = 1e-3;     // information about a coefficient that the lens model lacks

using Jacobian23 = Eigen::Matrix<double, 2, 3>;
using Coupling = Eigen::Matrix<double, 6, 3>;

constexpr int kLens = LensChange::SizeAtCompileTime;

/// Where a change of the lens moves most.
std::array<Eigen::Vector2d, 4> cornersOf(const CameraModel& camera) {
  const double right = camera.width - 1.0;
  const double bottom = camera.height - 1.0;
  return {{{0.0, 0.0}, {0.0, bottom}, {right, 0.0}, {right, bottom}}};
}

/// Derivative of a reprojection error by the coefficients of the lens.
class LensJacobian {
 public:
  explicit LensJacobian(const CameraModel& camera) : camera_(camera) {
    for (int i = 0; i < kLens; ++i) changed_.push_back(camera.withLensChange(LensChange::Unit(i)));
  }

  /// The raw pixel is measured and does not move. So a change of distortion moves the undistorted pixel the other
  /// way.
  Eigen::Matrix<double, 2, kLens> at(const Eigen::Vector2d& pixel) const {
    const auto [raw, jacobian] = camera_.distortWithJacobian(pixel);
    Eigen::Matrix<double, 2, kLens> by_coefficient;  // lens models are linear in them
    for (int i = 0; i < kLens; ++i)
      by_coefficient.col(i) = changed_[static_cast<std::size_t>(i)].distort(pixel) - raw;
    return jacobian.inverse() * by_coefficient;
  }

 private:
  const CameraModel& camera_;
  std::vector<CameraModel> changed_;
};

/// A linearised observation.
struct LinearView {
  int pose;
  Eigen::Matrix<double, 2, 6> by_pose;
  Jacobian23 by_point;
  Eigen::Matrix<double, 2, kLens> by_lens;
  Eigen::Vector2d error;
  double weight;
};

/// Normal equations over all poses (6 each) and the coefficients, points eliminated one by one.
class ReducedEquations {
 public:
  explicit ReducedEquations(std::size_t poses)
      : lens_(6 * static_cast<Eigen::Index>(poses)),
        hessian_(Eigen::MatrixXd::Zero(lens_ + kLens, lens_ + kLens)),
        gradient_(Eigen::VectorXd::Zero(lens_ + kLens)) {}

  /// Adds the views of a point and eliminates the point.
  void addPoint(const std::vector<LinearView>& views) {
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, kLens, 3> coupling_lens = Eigen::Matrix<double, kLens, 3>::Zero();
    std::vector<Coupling> couplings;
    for (const LinearView& view : views) {
      const Eigen::Index at = 6 * view.pose;
      const Eigen::Matrix<double, 6, 2> weighted_pose = view.weight * view.by_pose.transpose();
      const Eigen::Matrix<double, kLens, 2> weighted_lens = view.weight * view.by_lens.transpose();
      hessian_.block<6, 6>(at, at) += weighted_pose * view.by_pose;
      hessian_.block<6, kLens>(at, lens_) += weighted_pose * view.by_lens;
      hessian_.block<kLens, kLens>(lens_, lens_) += weighted_lens * view.by_lens;
      gradient_.segment<6>(at) += weighted_pose * view.error;
      gradient_.segment<kLens>(lens_) += weighted_lens * view.error;
      hessian += view.weight * view.by_point.transpose() * view.by_point;
      gradient += view.weight * view.by_point.transpose() * view.error;
      coupling_lens += weighted_lens * view.by_point;
      couplings.push_back(weighted_pose * view.by_point);
    }
    const Eigen::Matrix3d inverse = hessian.inverse();
    if (!inverse.allFinite()) return;
    for (std::size_t a = 0; a < views.size(); ++a) {
      const Eigen::Index row = 6 * views[a].pose;
      const Coupling scaled = couplings[a] * inverse;
      for (std::size_t b = 0; b < views.size(); ++b)
        hessian_.block<6, 6>(row, 6 * views[b].pose) -= scaled * couplings[b].transpose();
      hessian_.block<6, kLens>(row, lens_) -= scaled * coupling_lens.transpose();
      gradient_.segment<6>(row) -= scaled * gradient;
    }
    hessian_.block<kLens, kLens>(lens_, lens_) -= coupling_lens * inverse * coupling_lens.transpose();
    gradient_.segment<kLens>(lens_) -= coupling_lens * inverse * gradient;
  }

  /// Eliminates all poses but the first, which is fixed.
  LensInformation eliminatePoses() const {
    const Eigen::Index free = lens_ - 6;
    Eigen::MatrixXd poses = hessian_.block(6, 6, free, free);
    poses.diagonal() *= 1.0 + kUnitOfLength;
    const Eigen::LDLT<Eigen::MatrixXd> factor(poses);
    const Eigen::MatrixXd coupling = hessian_.block(6, lens_, free, kLens);
    const Eigen::MatrixXd solved = factor.solve(coupling);
    LensInformation information;
    information.hessian = hessian_.block<kLens, kLens>(lens_, lens_) - coupling.transpose() * solved;
    information.gradient = gradient_.segment<kLens>(lens_) - solved.transpose() * gradient_.segment(6, free);
    return information;
  }

 private:
  Eigen::Index lens_;  // first row of the coefficients
  Eigen::MatrixXd hessian_;
  Eigen::VectorXd gradient_;
};

/// The whole local map as a bundle problem. Observations are weighted by their residuals.
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
  std::vector<LinearView> views;  // of one point
  for (std::size_t i = 0; i < problem.observations.size(); ++i) {
    const BundleObservation& observation = problem.observations[i];
    const RigidTransform& pose = problem.poses[static_cast<std::size_t>(observation.pose)];
    const Eigen::Vector3d x = pose * problem.points[static_cast<std::size_t>(observation.point)];
    const Reprojection reprojection = reproject(camera, x, observation.pixel);
    const double normalised = reprojection.error.norm() / observation.sigma;
    if (reprojection.depth > 0.0 && normalised * normalised <= loss.gate) {
      const double weight = std::min(1.0, loss.huber / normalised) / (observation.sigma * observation.sigma);
      views.push_back({observation.pose, reprojection.byPose(x),
                       reprojection.byPoint(pose.rotation.toRotationMatrix()), lens.at(observation.pixel),
                       reprojection.error, weight});
    }
    const bool last =
        i + 1 == problem.observations.size() || problem.observations[i + 1].point != observation.point;
    if (!last) continue;
    if (views.size() >= kLeastViews) equations.addPoint(views);
    views.clear();
  }
  return equations.eliminatePoses();
}

std::optional<CameraModel> LensRefinement::update(const CameraModel& camera, const LocalMap& map,
                                                  const RobustLoss& loss) {
  const KeyframeId newest = map.keyframes().back().id;
  if (map.full() && (!measured_ || map.keyframes().front().id > *measured_)) {
    const LensInformation found = measureLens(camera, problemOf(camera, map, loss), loss);
    const Eigen::Matrix4d information = found.hessian / params_.correlated;
    if (cornerSigma(information) < params_.usable_sigma) {
      information_ += information;
      weighted_ += (found.hessian * applied_ - found.gradient) / params_.correlated;
    }
    measured_ = newest;
  }
  const LensChange wanted = estimate();
  worthwhile_ = worthwhile_ || (cornerShift(LensChange::Zero(), wanted) > params_.worthwhile_shift &&
                                wanted.dot(informationWithPrior() * wanted) > params_.significance);
  const double shift = cornerShift(applied_, wanted);
  if (!worthwhile_ || shift < kNegligibleShift) return std::nullopt;
  const LensChange next = applied_ + std::min(1.0, params_.shift_a_keyframe / shift) * (wanted - applied_);
  const CameraModel better = calibrated_.withLensChange(next);
  for (const Eigen::Vector2d& corner : cornersOf(camera)) {
    if (!(better.distortWithJacobian(corner).jacobian.determinant() > kLeastDeterminant)) return std::nullopt;
  }
  applied_ = next;
  return better;
}

LensChange LensRefinement::estimate() const { return informationWithPrior().ldlt().solve(weighted_); }

double LensRefinement::cornerSigma(Eigen::Matrix4d information) const {
  information.diagonal().array() += kNothingKnown;
  const Eigen::Matrix4d covariance = information.inverse();
  const LensJacobian lens(calibrated_);
  double sigma = 0.0;
  for (const Eigen::Vector2d& corner : cornersOf(calibrated_)) {
    const Eigen::Matrix<double, 2, kLens> by_lens = lens.at(corner);
    sigma = std::max(sigma, std::sqrt((by_lens * covariance * by_lens.transpose()).trace()));
  }
  return sigma;
}

Eigen::Matrix4d LensRefinement::informationWithPrior() const {
  const double radial = 1.0 / (params_.radial_sigma * params_.radial_sigma);
  const double tangential = 1.0 / (params_.tangential_sigma * params_.tangential_sigma);
  Eigen::Matrix4d information = information_;
  information.diagonal() += LensChange(radial, radial, tangential, tangential);
  return information;
}

double LensRefinement::cornerShift(const LensChange& from, const LensChange& to) const {
  const CameraModel before = calibrated_.withLensChange(from);
  const CameraModel after = calibrated_.withLensChange(to);
  double shift = 0.0;
  for (const Eigen::Vector2d& corner : cornersOf(calibrated_))
    shift = std::max(shift, (after.distort(corner) - before.distort(corner)).norm());
  return shift;
}

}  // namespace ratslam
