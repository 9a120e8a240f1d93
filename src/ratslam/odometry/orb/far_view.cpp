#include "ratslam/odometry/orb/far_view.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"
#include "ratslam/vision/matching.h"

namespace ratslam {
namespace {

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

constexpr int kMostDistance = 64;    // [bits]
constexpr double kMostRatio = 0.85;  // of the best distance to the second best
constexpr int kThoroughFeatures = 4000;
constexpr std::size_t kLeastMatches = 12;
constexpr double kTurnStepDeg = 0.5;
constexpr double kMostTurnDeg = 70.0;
constexpr double kMostPitchDeg = 3.0;
constexpr double kGridError = 3.0;   // [px]
constexpr double kError = 2.0;       // of a match that agrees in the end [px]
constexpr double kLeastSigma = 0.7;  // of matched features [px]
constexpr int kRounds = 20;
constexpr double kLeastShare = 0.2;  // of the matches that must agree
constexpr double kInflation = 2.0;   // of the covariance: near points that all look alike err together

struct Match {
  Eigen::Vector3d before;  // bearings, z = 1
  Eigen::Vector3d after;
};

/// For each descriptor of `from` the one most like it in `to`, or -1.
std::vector<int> mostSimilar(const cv::Mat& from, const cv::Mat& to) {
  std::vector<int> best(static_cast<std::size_t>(from.rows), -1);
  for (int i = 0; i < from.rows; ++i) {
    int least = kMostDistance + 1;
    int second = 256;
    int found = -1;
    for (int k = 0; k < to.rows; ++k) {
      const int distance = hammingDistance(from.ptr<std::uint8_t>(i), to.ptr<std::uint8_t>(k));
      if (distance < least) {
        second = least;
        least = distance;
        found = k;
      } else if (distance < second) {
        second = distance;
      }
    }
    if (found >= 0 && least <= kMostRatio * second) best[static_cast<std::size_t>(i)] = found;
  }
  return best;
}

struct Features {
  std::vector<Eigen::Vector3d> bearings;
  cv::Mat descriptors;
};

Features featuresOf(const CameraModel& camera, const Frame& frame, bool thorough, WorkerPool& workers) {
  Features result;
  std::vector<Feature> features = frame.features;
  result.descriptors = frame.descriptors;
  if (thorough) {
    ExtractorParams params;
    params.features = kThoroughFeatures;
    params.levels = frame.pyramid.levels();
    params.scale_factor = frame.pyramid.levels() > 1 ? frame.pyramid.scale(1) : params.scale_factor;
    features = FeatureExtractor(params).extract(frame.pyramid, result.descriptors, workers);
    for (Feature& feature : features) feature.pixel = camera.undistort(feature.raw);
  }
  for (const Feature& feature : features) result.bearings.push_back(camera.bearing(feature.pixel));
  return result;
}

std::vector<Match> matchFeatures(const Features& before, const Features& after) {
  const std::vector<int> forth = mostSimilar(before.descriptors, after.descriptors);
  const std::vector<int> back = mostSimilar(after.descriptors, before.descriptors);
  std::vector<Match> matches;
  for (std::size_t i = 0; i < forth.size(); ++i) {
    if (forth[i] < 0 || back[static_cast<std::size_t>(forth[i])] != static_cast<int>(i)) continue;
    matches.push_back({before.bearings[i], after.bearings[static_cast<std::size_t>(forth[i])]});
  }
  return matches;
}

/// Signed Sampson distances of the matches from a motion, in bearings.
class SampsonError {
 public:
  explicit SampsonError(const RigidTransform& motion)
      : essential_(skew(motion.translation) * motion.rotation.toRotationMatrix()) {}
  double operator()(const Match& match) const {
    const Eigen::Vector3d line_before = essential_ * match.after;
    const Eigen::Vector3d line_after = essential_.transpose() * match.before;
    const double slope = line_before.head<2>().squaredNorm() + line_after.head<2>().squaredNorm();
    return slope > 0.0 ? match.before.dot(line_before) / std::sqrt(slope) : 0.0;
  }

 private:
  Eigen::Matrix3d essential_;
};

int agreeing(const std::vector<Match>& matches, const RigidTransform& motion, double limit) {
  const SampsonError error(motion);
  return static_cast<int>(std::count_if(matches.begin(), matches.end(),
                                        [&](const Match& match) { return std::abs(error(match)) < limit; }));
}

/// The best motion of a vehicle: a turn, with the direction of its chord, and pitch.
RigidTransform searchTurn(const std::vector<Match>& matches, const UncertainMotion& predicted, double limit) {
  const double turn = logRotation(predicted.motion.rotation).y();
  const double reach =
      std::max(3.0 * std::sqrt(predicted.covariance(4, 4)), degreesToRadians(2.0 * kTurnStepDeg));
  const double most = degreesToRadians(kMostTurnDeg);
  const double step = degreesToRadians(kTurnStepDeg);
  const double ahead = predicted.motion.translation.z() < 0.0 ? -1.0 : 1.0;
  RigidTransform best;
  int most_agreeing = -1;
  for (double angle = std::max(-most, turn - reach); angle <= std::min(most, turn + reach); angle += step) {
    for (double pitch = -degreesToRadians(kMostPitchDeg); pitch <= degreesToRadians(kMostPitchDeg) + 1e-9;
         pitch += step) {
      RigidTransform motion;
      motion.rotation = expRotation({0.0, angle, 0.0}) * expRotation({pitch, 0.0, 0.0});
      motion.translation = ahead * (expRotation({0.0, 0.5 * angle, 0.0}) * Eigen::Vector3d::UnitZ());
      const int count = agreeing(matches, motion, limit);
      if (count > most_agreeing) {
        most_agreeing = count;
        best = motion;
      }
    }
  }
  return best;
}

/// The motion after small changes: rotation about the axes at the start, direction about two axes across it.
RigidTransform moved(const RigidTransform& motion, const Eigen::Matrix<double, 3, 2>& across,
                     const Vector5& change) {
  RigidTransform result;
  result.rotation = (expRotation(change.head<3>()) * motion.rotation).normalized();
  result.translation = (motion.translation + across * change.tail<2>()).normalized();
  return result;
}

Eigen::Matrix<double, 3, 2> axesAcross(const Eigen::Vector3d& direction) {
  Eigen::Matrix<double, 3, 2> axes;
  axes.col(0) = direction.unitOrthogonal();
  axes.col(1) = direction.cross(axes.col(0));
  return axes;
}

/// Refines rotation and direction. @param focal [px]. @return covariance filled.
UncertainMotion refined(const std::vector<Match>& matches, RigidTransform motion, double focal) {
  constexpr double kStep = 1e-6;
  Matrix5 hessian = Matrix5::Identity();
  Eigen::Matrix<double, 3, 2> across;
  double sigma = kGridError;
  for (int round = 0; round < kRounds; ++round) {
    across = axesAcross(motion.translation);
    const SampsonError error(motion);
    std::vector<SampsonError> shifted;
    for (int k = 0; k < 5; ++k) shifted.emplace_back(moved(motion, across, kStep * Vector5::Unit(k)));
    hessian = 1e-6 * Matrix5::Identity();
    Vector5 gradient = Vector5::Zero();
    std::vector<double> small;
    for (const Match& match : matches) {
      const double residual = focal * error(match);
      if (std::abs(residual) < 3.0 * kGridError) small.push_back(std::abs(residual));
      Vector5 jacobian;
      for (int k = 0; k < 5; ++k)
        jacobian(k) = (focal * shifted[static_cast<std::size_t>(k)](match) - residual) / kStep;
      const double normalised = residual / sigma;
      const double weight = 1.0 / (sigma * sigma * (1.0 + normalised * normalised));
      hessian += weight * jacobian * jacobian.transpose();
      gradient += weight * residual * jacobian;
    }
    const Vector5 change = -hessian.ldlt().solve(gradient);
    if (!change.allFinite()) break;
    motion = moved(motion, across, change);
    if (!small.empty()) {
      const auto middle = small.begin() + static_cast<std::ptrdiff_t>(small.size() / 2);
      std::nth_element(small.begin(), middle, small.end());
      sigma = std::max(kLeastSigma, std::min(0.9 * sigma, 1.5 * *middle));
    }
    if (change.squaredNorm() < 1e-14) break;
  }
  UncertainMotion result;
  result.motion = motion;
  Eigen::Matrix<double, 6, 5> spread = Eigen::Matrix<double, 6, 5>::Zero();
  spread.block<3, 2>(0, 3) = across;
  spread.block<3, 3>(3, 0) = Eigen::Matrix3d::Identity();
  result.covariance = kInflation * spread * hessian.ldlt().solve(Matrix5::Identity()) * spread.transpose();
  return result;
}

}  // namespace

std::optional<FarView> compareFarFeatures(const CameraModel& camera, const Frame& before, const Frame& after,
                                          const UncertainMotion& predicted, bool thorough,
                                          WorkerPool& workers) {
  const std::vector<Match> matches = matchFeatures(featuresOf(camera, before, thorough, workers),
                                                   featuresOf(camera, after, thorough, workers));
  if (matches.size() < kLeastMatches) return std::nullopt;
  FarView view;
  view.motion = refined(matches, searchTurn(matches, predicted, kGridError / camera.fx), camera.fx);
  view.points = agreeing(matches, view.motion.motion, kError / camera.fx);
  const bool enough = view.points >= static_cast<int>(kLeastMatches) &&
                      view.points >= kLeastShare * static_cast<double>(matches.size());
  if (!enough || !view.motion.covariance.allFinite()) return std::nullopt;
  return view;
}

}  // namespace ratslam
