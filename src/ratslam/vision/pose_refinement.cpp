#include "ratslam/vision/pose_refinement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

constexpr int kRounds = 4;
constexpr int kStepsPerRound = 4;
constexpr std::size_t kMinObservations = 6;
constexpr double kConverged = 1e-9;  // squared length of a step below which a round ends

struct NormalEquations {
  Matrix6 hessian = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
};

/// @param gate_active in the first round nothing is left out: the initial pose may be far off.
NormalEquations accumulate(const CameraModel& camera, const RigidTransform& pose,
                           const std::vector<PoseObservation>& observations, const RobustLoss& loss,
                           double sigma, bool gate_active) {
  NormalEquations equations;
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  for (const PoseObservation& observation : observations) {
    const Eigen::Vector3d x = rotation * observation.point + pose.translation;
    const Reprojection reprojection = reproject(camera, x, observation.pixel);
    if (reprojection.depth <= kMinDepth) continue;
    const double deviation = observation.sigma * sigma;
    const double normalised = reprojection.error.norm() / deviation;
    if (gate_active && normalised * normalised > loss.gate) continue;
    const double weight = (normalised > loss.huber ? loss.huber / normalised : 1.0) / (deviation * deviation);
    const Eigen::Matrix<double, 2, 6> jacobian = reprojection.byPose(x);
    equations.hessian.noalias() += weight * jacobian.transpose() * jacobian;
    equations.gradient.noalias() += weight * jacobian.transpose() * reprojection.error;
  }
  return equations;
}

}  // namespace

double robustSigma(std::vector<double> error_lengths) {
  if (error_lengths.empty()) return 0.0;
  const auto middle = error_lengths.begin() + static_cast<std::ptrdiff_t>(error_lengths.size() / 2);
  std::nth_element(error_lengths.begin(), middle, error_lengths.end());
  constexpr double kRayleighMedian = 1.1774100225154747;  // sqrt(2 ln 2): median length at unit deviation
  return *middle / kRayleighMedian;
}

PoseEstimate refinePose(const CameraModel& camera, const RigidTransform& initial,
                        const std::vector<PoseObservation>& observations, const RobustLoss& loss) {
  PoseEstimate estimate;
  estimate.T_camera_world = initial;
  estimate.inlier.assign(observations.size(), false);
  if (observations.size() < kMinObservations) return estimate;

  std::vector<double> lengths(observations.size());
  const auto measureErrors = [&] {
    std::vector<double> in_front;
    for (std::size_t i = 0; i < observations.size(); ++i) {
      const Reprojection reprojection =
          reproject(camera, estimate.T_camera_world * observations[i].point, observations[i].pixel);
      lengths[i] = reprojection.depth > kMinDepth ? reprojection.error.norm() / observations[i].sigma
                                                  : std::numeric_limits<double>::infinity();
      if (reprojection.depth > kMinDepth) in_front.push_back(lengths[i]);
    }
    estimate.sigma = std::max(loss.min_sigma, robustSigma(std::move(in_front)));
  };

  NormalEquations equations;
  for (int round = 0; round < kRounds; ++round) {
    measureErrors();
    for (int step = 0; step < kStepsPerRound; ++step) {
      equations = accumulate(camera, estimate.T_camera_world, observations, loss, estimate.sigma, round > 0);
      // A trace of damping keeps a singular system (all points far away, or in a line) solvable.
      equations.hessian.diagonal() *= 1.0 + 1e-9;
      const Eigen::LDLT<Matrix6> factor(equations.hessian);
      const Vector6 increment = -factor.solve(equations.gradient);
      if (factor.info() != Eigen::Success || !increment.allFinite()) return estimate;
      estimate.T_camera_world = expTransform(increment) * estimate.T_camera_world;
      if (increment.squaredNorm() < kConverged * kConverged) break;
    }
  }
  measureErrors();
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const double normalised = lengths[i] / estimate.sigma;
    estimate.inlier[i] = normalised * normalised <= loss.gate;
    estimate.inliers += estimate.inlier[i] ? 1 : 0;
  }
  const Eigen::LDLT<Matrix6> factor(equations.hessian);
  const Matrix6 covariance = factor.solve(Matrix6::Identity());
  if (covariance.allFinite()) estimate.covariance = 0.5 * (covariance + covariance.transpose());
  return estimate;
}

}  // namespace ratslam
