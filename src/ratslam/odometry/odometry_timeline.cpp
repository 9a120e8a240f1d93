#include "ratslam/odometry/odometry_timeline.h"

#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"
#include "ratslam/odometry/possible.h"
#include "ratslam/odometry/uncertainty.h"

namespace ratslam {
namespace {

/// A pose jumps if it moves by this factor faster than the fastest motion so far, or turns by more than an angle.
/// The time is taken longer than it is by kStampError_s, because stamps and twists are not exact.
constexpr double kJump = 3.0;
constexpr double kJumpOfPoseOnly = 10.0;
constexpr double kStampError_s = 0.1;
constexpr double kTurnError = 0.5;

/// Least values of the fastest motion that an unmeasured stretch may have had [m/s, rad/s].
constexpr double kLeastSpeed = 0.01;
constexpr double kLeastYawRate = 0.1;
/// Standard deviation of the vertical speed on an unmeasured stretch, as a share of the speed.
constexpr double kClimb = 0.2;

/// Bound on samples that nobody has consumed. Beyond it old ones are joined: if the consumer is dead, memory must
/// not grow without end.
constexpr std::size_t kMostPending = 20000;

double wayOf(const OdometryStep& step) {
  return std::sqrt(step.forward * step.forward + step.left * step.left + step.up * step.up);
}

OdometryStep stepByTwist(const OdometrySample& sample, double dt) {
  OdometryStep step;
  step.dt = dt;
  step.rotation = sample.yaw_rate * dt;
  step.forward = sample.speed * dt;
  return step;
}

OdometryStep stepByPose(const Eigen::Isometry3d& before, const Eigen::Isometry3d& after, double dt) {
  const double yaw = yawOf(after);
  const Eigen::Vector3d moved = after.translation() - before.translation();
  OdometryStep step;
  step.dt = dt;
  step.rotation = wrapAngle(yaw - yawOf(before));
  step.forward = std::cos(yaw) * moved.x() + std::sin(yaw) * moved.y();
  step.left = -std::sin(yaw) * moved.x() + std::cos(yaw) * moved.y();
  step.up = moved.z();
  return step;
}

/// Joins two consecutive steps.
OdometryStep joinedSteps(const OdometryStep& first, const OdometryStep& second) {
  OdometryStep both = second;
  const double c = std::cos(second.rotation);
  const double s = std::sin(second.rotation);
  both.dt += first.dt;
  both.rotation += first.rotation;
  both.forward += c * first.forward + s * first.left;
  both.left += -s * first.forward + c * first.left;
  both.up += first.up;
  if (first.covariance && second.covariance) *both.covariance += *first.covariance;
  both.new_unit = first.new_unit || second.new_unit;
  both.bridged = first.bridged || second.bridged;
  return both;
}

/// The part of `whole` between the fractions `from` and `to` of its time.
OdometryStep partOf(const OdometryStep& whole, bool from_pose, double from, double to, double dt) {
  const double share = to - from;
  OdometryStep part = whole;
  part.dt = dt;
  part.rotation *= share;
  part.forward *= share;
  part.left *= share;
  part.up *= share;
  if (part.covariance) *part.covariance *= share;
  part.new_unit = whole.new_unit && from == 0.0;
  if (from_pose) {
    // A displacement from poses is a chord, which is straight in space. Only the robot's axes turn, in which it is
    // expressed.
    const double left_to_turn = whole.rotation * (1.0 - to);
    const double c = std::cos(left_to_turn);
    const double s = std::sin(left_to_turn);
    const double forward = part.forward;
    part.forward = c * forward - s * part.left;
    part.left = s * forward + c * part.left;
  }
  return part;
}

}  // namespace

SampleVerdict OdometryTimeline::push(const OdometrySample& sample) {
  if (!whyImpossible(sample).empty()) return SampleVerdict::kImpossible;
  if (last_ && sample.stamp == last_->stamp) return SampleVerdict::kRepeatedStamp;
  if (last_ && sample.stamp < last_->stamp) {
    return secondsBetween(sample.stamp, last_->stamp) < params_.odometry_reset ? SampleVerdict::kLate
                                                                               : SampleVerdict::kTimeWentBack;
  }
  if (last_) {
    pending_.push_back(intervalTo(sample));
    if (pending_.size() > kMostPending) {
      // The consumer is so late that the shape of the path in between no longer matters.
      Interval& joined = pending_[1];
      const Interval& next = pending_[2];
      joined.whole = joinedSteps(joined.whole, next.whole);
      joined.end = next.end;
      joined.from_pose = true;
      if (next.correction) joined.correction = next.correction;
      pending_.erase(pending_.begin() + 2);
    }
  } else {
    start_ = cursor_ = sample.stamp;
  }
  last_ = sample;
  return SampleVerdict::kAccepted;
}

OdometryTimeline::Interval OdometryTimeline::intervalTo(const OdometrySample& sample) {
  Interval interval;
  interval.begin = last_->stamp;
  interval.end = sample.stamp;
  interval.correction = sample.correction;
  const double dt = secondsBetween(interval.begin, interval.end);
  const OdometryStep by_twist = stepByTwist(sample, dt);
  // At a correction the pose jumps to its corrected place. So the motion of this sample is that of the twist.
  const bool with_poses = sample.pose && last_->pose && !sample.correction;
  const OdometryStep by_pose = with_poses ? stepByPose(*last_->pose, *sample.pose, dt) : by_twist;
  const bool pose_only = with_poses && sample.speed == 0.0 && sample.yaw_rate == 0.0 &&
                         (wayOf(by_pose) > 0.0 || by_pose.rotation != 0.0) && !sample.unit;
  const bool said = sample.covariance && whyAbsurd(*sample.covariance).empty();
  const bool another_epoch = sample.epoch != last_->epoch;
  const bool jumped = with_poses && !another_epoch && contradicts(by_pose, by_twist, pose_only);
  // A covariance of the twist alone may hold for the moment only. A source that also states its unit vouches for
  // the whole time since its last sample, and for its motion if it corrects its pose.
  const bool vouched = said && sample.unit;
  const bool silent = dt > params_.odometry_gap && !vouched;
  const bool broken = jumped && !vouched;
  const bool loose = broken || silent || ((another_epoch || sample.bridged) && !said);

  interval.from_pose = with_poses && !jumped && !another_epoch && (use_pose_ || pose_only || silent);
  interval.whole = interval.from_pose ? by_pose : by_twist;
  if (silent && !interval.from_pose) {
    interval.whole = OdometryStep{};
    interval.whole.dt = dt;
  }
  if (sample.pose) interval.whole.tilt = tiltOf(*sample.pose);
  interval.tilt_before = last_->pose ? tiltOf(*last_->pose) : interval.whole.tilt;
  interval.whole.unit = sample.unit;
  interval.whole.new_unit = another_epoch || broken;
  interval.whole.bridged = sample.bridged || loose;
  if (loose) {
    ++unmeasured_;
    interval.whole.covariance = looseCovariance(dt);
  } else {
    if (said) interval.whole.covariance = stepCovariance(*sample.covariance, interval.whole.tilt, dt);
    fastest_ = std::max(fastest_, std::max(std::abs(sample.speed), wayOf(interval.whole) / dt));
    fastest_turn_ = std::max(fastest_turn_, std::abs(interval.whole.rotation) / dt);
  }
  return interval;
}

bool OdometryTimeline::contradicts(const OdometryStep& by_pose, const OdometryStep& by_twist,
                                   bool pose_only) const {
  const double time = by_pose.dt + kStampError_s;
  if (pose_only) return fastest_ > 0.0 && wayOf(by_pose) > kJumpOfPoseOnly * fastest_ * time;
  const double fastest = std::max(fastest_, std::abs(by_twist.forward) / by_twist.dt);
  const double fastest_turn = std::max(fastest_turn_, std::abs(by_twist.rotation) / by_twist.dt);
  const double turned = std::abs(wrapAngle(by_pose.rotation - by_twist.rotation));
  return wayOf(by_pose) > kJump * fastest * time + kLeastSpeed * time ||
         turned > kTurnError + kJump * fastest_turn * time;
}

StepCovariance OdometryTimeline::looseCovariance(double dt) const {
  const double way = std::max(fastest_, kLeastSpeed) * dt;
  const double turn = std::min(kPi, std::max(fastest_turn_, kLeastYawRate) * dt);
  const Eigen::Vector4d sigmas(way, way, kClimb * way, turn);
  return sigmas.cwiseAbs2().asDiagonal();
}

TimedStep OdometryTimeline::stepOf(const Interval& interval, Stamp from, Stamp to) const {
  TimedStep timed{to, interval.whole, std::nullopt};
  if (to == interval.end) timed.correction = interval.correction;
  if (from == interval.begin && to == interval.end) return timed;
  const double length = static_cast<double>(interval.end - interval.begin);
  const double share_before = static_cast<double>(from - interval.begin) / length;
  const double share_after = static_cast<double>(to - interval.begin) / length;
  timed.step =
      partOf(interval.whole, interval.from_pose, share_before, share_after, secondsBetween(from, to));
  timed.step.tilt = interval.tilt_before.slerp(share_after, interval.whole.tilt);
  return timed;
}

std::vector<TimedStep> OdometryTimeline::advanceTo(Stamp stamp) {
  std::vector<TimedStep> steps;
  while (!pending_.empty() && cursor_ < stamp) {
    const Interval& next = pending_.front();
    const Stamp end = std::min(stamp, next.end);
    steps.push_back(stepOf(next, cursor_, end));
    cursor_ = end;
    if (end == next.end) pending_.pop_front();
  }
  return steps;
}

std::vector<TimedStep> OdometryTimeline::lookAhead(Stamp from) const {
  std::vector<TimedStep> steps;
  auto next = std::partition_point(pending_.begin(), pending_.end(),
                                   [from](const Interval& interval) { return interval.end <= from; });
  for (; next != pending_.end(); ++next) {
    steps.push_back(stepOf(*next, from, next->end));
    from = next->end;
  }
  return steps;
}

void OdometryTimeline::reset() {
  const std::uint64_t unmeasured = unmeasured_;
  *this = OdometryTimeline(use_pose_, params_);
  unmeasured_ = unmeasured;
}

}  // namespace ratslam
