#include "ratslam/odometry/orb/far_view.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"
#include "ratslam/common/statistics.h"
#include "ratslam/vision/matching.h"

namespace ratslam {
namespace {

using Vector5 = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;

constexpr int kMostDistance = 64;    // of matched descriptors [bits]
constexpr double kMostRatio = 0.85;  // best distance / second best
constexpr int kThoroughFeatures = 4000;
constexpr std::size_t kLeastMatches = 12;
constexpr double kTurnStepDeg = 0.5;
constexpr double kMostTurnDeg = 70.0;
constexpr double kMostPitchDeg = 3.0;
constexpr double kGridError = 3.0;   // [px]
constexpr double kError = 2.0;       // largest error of an inlier after refinement [px]
constexpr double kLeastSigma = 0.7;  // of matched features [px]
constexpr int kRounds = 20;
constexpr double kFalseAlarms = 1e-3;  // bound on the expected number of chance motions among those tried
constexpr std::size_t kShuffles = 20;  // random pairings of the matches, to measure chance agreement
constexpr double kInflation = 2.0;     // factor of the covariance: similar near points have correlated errors
// Prior knowledge about a vehicle, as standard deviations [deg]: it hardly rolls and pitches, and the direction of
// its chord is half its turn if the camera is not far from the rear axle.
constexpr double kRollDeg = 1.0;
constexpr double kPitchDeg = 1.5;
constexpr double kChordDeg = 6.0;
constexpr double kSlopeDeg = 2.0;
// Errors over a long distance that no number of points averages out: lens distortion, moving cars, repetitive
// walls [deg].
constexpr double kFarTurnDeg = 0.5;
constexpr double kFarDirectionDeg = 1.0;
constexpr std::size_t kGroups = 10;     // groups of matches, each left out once
constexpr double kRivalDeg = 5.0;       // a turn that differs by more from the best one is a rival
constexpr double kClearlyBetter = 2.0;  // lead over a rival, in standard deviations of its number of matches

struct Match {
  Eigen::Vector3d before;  // bearings, z = 1
  Eigen::Vector3d after;
};

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
  std::vector<Match> matches;
  for (const auto& [here, there] :
       mutuallyMostSimilar(before.descriptors, after.descriptors, kMostDistance, kMostRatio)) {
    matches.push_back({before.bearings[here], after.bearings[there]});
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

double aheadOrBack(const UncertainMotion& predicted) {
  return predicted.motion.translation.z() < 0.0 ? -1.0 : 1.0;
}

struct SearchedTurn {
  RigidTransform motion;
  int points = 0;
  int tried = 0;         ///< number of motions tried
  int rival_points = 0;  ///< inliers of the best clearly different turn
};

/// The motion of a vehicle with most inliers: a turn, the direction of its chord, and pitch.
SearchedTurn searchTurn(const std::vector<Match>& matches, const UncertainMotion& predicted, double limit) {
  const double turn = logRotation(predicted.motion.rotation).y();
  const double reach =
      std::max(3.0 * std::sqrt(predicted.covariance(4, 4)), degreesToRadians(2.0 * kTurnStepDeg));
  const double most = degreesToRadians(kMostTurnDeg);
  const double step = degreesToRadians(kTurnStepDeg);
  const double ahead = aheadOrBack(predicted);
  SearchedTurn best;
  double best_angle = turn;
  std::vector<std::pair<double, int>> profile;  // turn, matches
  for (double angle = std::max(-most, turn - reach); angle <= std::min(most, turn + reach); angle += step) {
    profile.emplace_back(angle, 0);
    for (double pitch = -degreesToRadians(kMostPitchDeg); pitch <= degreesToRadians(kMostPitchDeg) + 1e-9;
         pitch += step) {
      RigidTransform motion;
      motion.rotation = expRotation({0.0, angle, 0.0}) * expRotation({pitch, 0.0, 0.0});
      motion.translation = ahead * (expRotation({0.0, 0.5 * angle, 0.0}) * Eigen::Vector3d::UnitZ());
      const int count = agreeing(matches, motion, limit);
      ++best.tried;
      profile.back().second = std::max(profile.back().second, count);
      if (count > best.points) {
        best.points = count;
        best.motion = motion;
        best_angle = angle;
      }
    }
  }
  for (const auto& [angle, count] : profile) {
    if (std::abs(angle - best_angle) >= degreesToRadians(kRivalDeg))
      best.rival_points = std::max(best.rival_points, count);
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

/// Residuals of a motion to the prior knowledge about a vehicle, normalised: roll, pitch, slope and chord.
Eigen::Vector4d unlikeAVehicle(const RigidTransform& motion, double ahead) {
  const Eigen::Vector3d turn = logRotation(motion.rotation);
  const Eigen::Vector3d chord = ahead * (expRotation({0.0, 0.5 * turn.y(), 0.0}) * Eigen::Vector3d::UnitZ());
  const Eigen::Vector3d off = motion.translation - chord;
  const double sideways = Eigen::Vector3d::UnitY().cross(chord).dot(off);
  return Eigen::Vector4d(turn.z() / kRollDeg, turn.x() / kPitchDeg, off.y() / kSlopeDeg,
                         sideways / kChordDeg) *
         radiansToDegrees(1.0);
}

struct Refined {
  RigidTransform motion;
  Eigen::Matrix<double, 3, 2> across;  // axes of the change of direction
  Matrix5 covariance = Matrix5::Identity();
};

/// Refines rotation and direction. @param focal [px].
Refined refineOnce(const std::vector<Match>& matches, RigidTransform motion, double focal, double ahead) {
  constexpr double kStep = 1e-6;
  Matrix5 hessian = Matrix5::Identity();
  Eigen::Matrix<double, 3, 2> across;
  double sigma = kGridError;
  for (int round = 0; round < kRounds; ++round) {
    across = axesAcross(motion.translation);
    const SampsonError error(motion);
    const Eigen::Vector4d unlike = unlikeAVehicle(motion, ahead);
    std::vector<SampsonError> shifted;
    Eigen::Matrix<double, 4, 5> unlike_by;
    for (int k = 0; k < 5; ++k) {
      const RigidTransform near = moved(motion, across, kStep * Vector5::Unit(k));
      shifted.emplace_back(near);
      unlike_by.col(k) = (unlikeAVehicle(near, ahead) - unlike) / kStep;
    }
    hessian = unlike_by.transpose() * unlike_by + 1e-6 * Matrix5::Identity();
    Vector5 gradient = unlike_by.transpose() * unlike;
    std::vector<double> small;
    for (const Match& match : matches) {
      const double residual = focal * error(match);
      if (std::abs(residual) < 3.0 * kGridError) small.push_back(std::abs(residual));
      Vector5 jacobian;
      for (int k = 0; k < 5; ++k)
        jacobian(k) = (focal * shifted[static_cast<std::size_t>(k)](match) - residual) / kStep;
      const double normalised = residual / sigma;
      const double share = 1.0 + normalised * normalised;
      const double weight = 1.0 / (sigma * sigma * share);
      hessian += weight * jacobian * jacobian.transpose();
      gradient += weight * residual * jacobian;
    }
    const Vector5 change = -hessian.ldlt().solve(gradient);
    if (!change.allFinite()) break;
    motion = moved(motion, across, change);
    if (!small.empty()) sigma = std::max(kLeastSigma, std::min(0.9 * sigma, 1.5 * median(small)));
    if (change.squaredNorm() < 1e-14) break;
  }
  return {motion, across, hessian.ldlt().solve(Matrix5::Identity())};
}

/// The same, with the covariance of a jackknife over groups of matches (Efron and Stein 1981): each tenth is left
/// out once. So the covariance contains the influence of single matches, wrong ones included.
UncertainMotion refined(const std::vector<Match>& matches, const RigidTransform& start, double focal,
                        double ahead, bool far) {
  const Refined best = refineOnce(matches, start, focal, ahead);
  Matrix5 covariance = kInflation * best.covariance;
  if (far) {
    covariance.diagonal().head<3>().array() += std::pow(degreesToRadians(kFarTurnDeg), 2);
    covariance.diagonal().tail<2>().array() += std::pow(degreesToRadians(kFarDirectionDeg), 2);
  }
  for (std::size_t group = 0; group < kGroups; ++group) {
    std::vector<Match> others;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (i % kGroups != group) others.push_back(matches[i]);
    }
    const RigidTransform without = refineOnce(others, best.motion, focal, ahead).motion;
    Vector5 change;
    change.head<3>() = logRotation(without.rotation * best.motion.rotation.conjugate());
    change.tail<2>() = best.across.transpose() * (without.translation - best.motion.translation);
    covariance +=
        static_cast<double>(kGroups - 1) / static_cast<double>(kGroups) * change * change.transpose();
  }
  UncertainMotion result;
  result.motion = best.motion;
  Eigen::Matrix<double, 6, 5> spread = Eigen::Matrix<double, 6, 5>::Zero();
  spread.block<3, 2>(0, 3) = best.across;
  spread.block<3, 3>(3, 0) = Eigen::Matrix3d::Identity();
  result.covariance = spread * covariance * spread.transpose();
  return result;
}

/// Whether more matches agree with a motion than chance explains (a contrario test, Moisan and Stival 2004): the
/// expected number of tried motions with as many agreeing wrong matches must be small. Random pairings of the
/// features show how often a wrong match agrees, because scenes have structure.
bool isEvidence(const std::vector<Match>& matches, const RigidTransform& motion, int points, int tried,
                double limit) {
  const std::size_t n = matches.size();
  std::vector<Match> shuffled;
  for (std::size_t shift = 1; shift <= std::min(kShuffles, n - 1); ++shift) {
    for (std::size_t i = 0; i < n; ++i)
      shuffled.push_back({matches[i].before, matches[(i + shift) % n].after});
  }
  const double chance =
      (1.0 + agreeing(shuffled, motion, limit)) / (1.0 + static_cast<double>(shuffled.size()));
  const auto count = static_cast<double>(n);
  const double k = points;
  const double log_ways = std::lgamma(count + 1.0) - std::lgamma(k + 1.0) - std::lgamma(count - k + 1.0);
  return std::log(tried) + log_ways + k * std::log(chance) < std::log(kFalseAlarms);
}

}  // namespace

std::optional<FarView> compareFarFeatures(const CameraModel& camera, const Frame& before, const Frame& after,
                                          const UncertainMotion& predicted, bool thorough,
                                          WorkerPool& workers) {
  const std::vector<Match> matches = matchFeatures(featuresOf(camera, before, thorough, workers),
                                                   featuresOf(camera, after, thorough, workers));
  if (matches.size() < kLeastMatches) return std::nullopt;
  FarView view;
  const SearchedTurn turn = searchTurn(matches, predicted, kGridError / camera.fx);
  // Walls and windows are repetitive. If another turn has almost as many inliers, neither is reliable.
  if (turn.points - turn.rival_points <= kClearlyBetter * std::sqrt(turn.rival_points)) return std::nullopt;
  view.motion = refined(matches, turn.motion, camera.fx, aheadOrBack(predicted), thorough);
  const double limit = kError / camera.fx;
  view.points = agreeing(matches, view.motion.motion, limit);
  const bool enough = view.points >= static_cast<int>(kLeastMatches) && view.motion.covariance.allFinite();
  if (!enough || !isEvidence(matches, view.motion.motion, view.points, turn.tried, limit))
    return std::nullopt;
  return view;
}

}  // namespace ratslam
