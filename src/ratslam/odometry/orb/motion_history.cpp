#include "ratslam/odometry/orb/motion_history.h"

#include <algorithm>
#include <cmath>

#include "ratslam/odometry/prediction.h"

namespace ratslam {
namespace {

constexpr double kKept = 1.5;         // time for which measurements are kept [s]
constexpr double kLag = 1.0;          // interval over which changes are measured [s]
constexpr double kShortestLag = 0.3;  // [s]
constexpr double kMemory = 60.0;      // time constant of the learned diffusions [s]
constexpr std::size_t kAveraged = 3;  // measurements in the mean twist
constexpr double kPriorWeight = 3.0;  // of the prior of the diffusion [s]
constexpr double kPriorSpeed = 0.15;  // prior: change of the speed within a second / speed
// Least change of the turn rate within a second [rad/s]: a straight road does not predict the next turn.
constexpr double kLeastTurn = 0.2;
// The same between two known turn rates, for the curves of a road; and the duration of a turn [s]. On drives along
// the roads of KITTI 00 and 02 the heading changes by 3 degrees in 3 s where the road is straight. In turns the
// error is half the turn that one of the two rates alone would make.
constexpr double kCurves = 0.035;
constexpr double kTurnLasts = 6.0;
constexpr double kMostOfATurn = 0.5;
constexpr double kUnknownTurn = 0.2;  // [rad/s]
constexpr double kTilting = 0.1;      // variance of pitch and roll / variance of yaw
constexpr double kSideways = 0.05;    // standard deviation across the direction of travel / distance

}  // namespace

void MotionHistory::add(Stamp stamp, const Vector6& twist) {
  while (!recent_.empty() && secondsBetween(recent_.front().stamp, stamp) > kKept) recent_.pop_front();
  if (!recent_.empty()) {
    const Measurement* then = nullptr;
    for (const Measurement& measurement : recent_) {
      if (secondsBetween(measurement.stamp, stamp) < kShortestLag) break;
      then = &measurement;
      if (secondsBetween(measurement.stamp, stamp) <= kLag) break;
    }
    if (then) {
      const double lag = secondsBetween(then->stamp, stamp);
      const double share = std::min(kLag, secondsBetween(recent_.back().stamp, stamp));
      const double keep = std::exp(-share / kMemory);
      const Vector6 change = twist - then->twist;
      weight_ = keep * weight_ + share;
      speed_changes_ = keep * speed_changes_ + share * change(2) * change(2) / lag;
      turn_changes_ = keep * turn_changes_ + share * change.tail<3>().squaredNorm() / lag;
    }
  }
  recent_.push_back({stamp, twist});
}

Vector6 MotionHistory::twist() const {
  Vector6 sum = Vector6::Zero();
  const std::size_t count = std::min(kAveraged, recent_.size());
  for (std::size_t i = 0; i < count; ++i) sum += recent_[recent_.size() - 1 - i].twist;
  return count == 0 ? sum : Vector6(sum / static_cast<double>(count));
}

void MotionHistory::rescale(double factor) {
  for (Measurement& measurement : recent_) measurement.twist.head<3>() *= factor;
  speed_changes_ *= factor * factor;
}

double MotionHistory::speedDiffusion() const {
  const double prior = std::pow(kPriorSpeed * twist().head<3>().norm(), 2);
  return (kPriorWeight * prior + speed_changes_) / (kPriorWeight + weight_);
}

double MotionHistory::turnDiffusion() const {
  const double learned = weight_ > 0.0 ? turn_changes_ / weight_ : 0.0;
  return std::max(kLeastTurn * kLeastTurn, learned);
}

Matrix6 MotionHistory::spread(const Eigen::Vector3d& way, double speed_variance, double turn_variance) {
  Matrix6 covariance = Matrix6::Zero();
  const double square = way.squaredNorm() + speed_variance;  // mean square of the distance
  const double across = square * (kSideways * kSideways + turn_variance / 3.0);
  const Eigen::Vector3d ahead =
      way.norm() > 1e-9 ? Eigen::Vector3d(way.normalized()) : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d turning = turn_variance * Eigen::Vector3d(kTilting, 1.0, kTilting);
  // A turn that is distributed over the motion displaces its end sideways by half of the turn.
  const Eigen::Matrix3d aside = -0.5 * skew(way);
  covariance.topLeftCorner<3, 3>() =
      across * Eigen::Matrix3d::Identity() + speed_variance * ahead * ahead.transpose();
  covariance.topRightCorner<3, 3>() = aside * turning.asDiagonal();
  covariance.bottomLeftCorner<3, 3>() = covariance.topRightCorner<3, 3>().transpose();
  covariance.diagonal().tail<3>() = turning;
  return covariance;
}

UncertainMotion MotionHistory::along(const Vector6& twist, double duration, double speed_variance,
                                     double turn_variance) const {
  UncertainMotion result;
  result.motion = expTransform(twist * duration);
  result.covariance = spread(result.motion.translation, speed_variance, turn_variance);
  return result;
}

UncertainMotion MotionHistory::predict(double begin, double end) const {
  // Distance is the integral of a random walk: its variance grows with the third power of time.
  if (recent_.empty()) {
    const double square = end * end - begin * begin;  // the unknown speed is constant
    return along(Vector6::Zero(), end - begin, square * unknown_speed_ * unknown_speed_,
                 square * kUnknownTurn * kUnknownTurn);
  }
  Vector6 goes_on = twist();
  goes_on(3) = goes_on(5) = 0.0;  // pitch and roll of a vehicle return
  const double grown = (std::pow(end, 3) - std::pow(begin, 3)) / 3.0;
  const double moving = std::min(end, kLongestPrediction_s) - std::min(begin, kLongestPrediction_s);
  return along(goes_on, moving, speedDiffusion() * grown, turnDiffusion() * grown);
}

double MotionHistory::turnVariance(const Eigen::Vector3d& before, const Eigen::Vector3d& after,
                                   double duration) {
  const double curves = kCurves * kCurves * std::pow(duration, 3) / 12.0;  // a random walk known at both ends
  const double rate = std::max(before.norm(), after.norm());
  const double turn = std::min(kMostOfATurn, duration / kTurnLasts) * rate * duration;
  return curves + turn * turn;
}

}  // namespace ratslam
