#include "ratslam/vision/pose_refinement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "ratslam/common/statistics.h"

namespace ratslam {
namespace {

constexpr int kRounds = 4;
constexpr int kStepsPerRound = 4;
constexpr std::size_t kMinObservations = 6;
constexpr double kConverged = 1e-9;  // a smaller squared length of a step ends a round

/// Cells of the image within which errors may be correlated.
constexpr int kColumns = 8;
constexpr int kRows = 4;

struct NormalEquations {
  Matrix6 hessian = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
};

/// @param gate_active false in the first round, because the initial pose may be far off.
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

/// Covariance of the pose for correlated errors of neighbouring observations, for example on a moving object or on a
/// facade that is matched a pixel off. The gradients are summed over the cells of a grid, and the sums count as
/// independent (sandwich estimator: Huber, Robust Statistics, 6.3; clustered: Liang and Zeger 1986).
Matrix6 clusteredCovariance(const CameraModel& camera, const PoseEstimate& estimate,
                            const std::vector<PoseObservation>& observations, const RobustLoss& loss,
                            const Matrix6& inverse_hessian) {
  const auto cell_of = [](double at, int size, int cells) {
    return static_cast<int>(std::clamp(at * cells / std::max(size, 1), 0.0, cells - 1.0));
  };
  std::array<std::vector<PoseObservation>, kColumns * kRows> cells;
  for (const PoseObservation& observation : observations) {
    const int row = cell_of(observation.pixel.y(), camera.height, kRows);
    const int column = cell_of(observation.pixel.x(), camera.width, kColumns);
    cells[static_cast<std::size_t>(row * kColumns + column)].push_back(observation);
  }
  Matrix6 spread = Matrix6::Zero();
  double seen = 0.0;
  for (const std::vector<PoseObservation>& cell : cells) {
    if (cell.empty()) continue;
    const Vector6 gradient =
        accumulate(camera, estimate.T_camera_world, cell, loss, estimate.sigma, true).gradient;
    spread.noalias() += gradient * gradient.transpose();
    seen += 1.0;
  }
  // The fit of the six pose parameters to these cells has reduced their spread.
  const double left = std::max(seen - 6.0, 1.0) / std::max(seen, 1.0);
  return inverse_hessian * spread * inverse_hessian / left;
}

}  // namespace

double robustSigma(std::vector<double> error_lengths) {
  if (error_lengths.empty()) return 0.0;
  constexpr double kRayleighMedian = 1.1774100225154747;  // sqrt(2 ln 2): median length at unit deviation
  return median(std::move(error_lengths)) / kRayleighMedian;
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
      // A little damping keeps a singular system (all points far away, or in a line) solvable.
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
  const Matrix6 inverse = factor.solve(Matrix6::Identity());
  // For independent errors both are right. The clustered one is noisy, because the cells are few.
  const Matrix6 covariance =
      0.5 * (inverse + clusteredCovariance(camera, estimate, observations, loss, inverse));
  if (covariance.allFinite()) estimate.covariance = 0.5 * (covariance + covariance.transpose());
  return estimate;
}

}  // namespace ratslam
