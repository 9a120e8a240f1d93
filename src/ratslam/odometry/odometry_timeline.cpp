#include "ratslam/odometry/odometry_timeline.h"

#include <cmath>

#include "ratslam/common/angles.h"

namespace ratslam {
namespace {

double yawOf(const Eigen::Isometry3d& pose) { return std::atan2(pose.linear()(1, 0), pose.linear()(0, 0)); }

bool isFinite(const OdometrySample& sample) {
  return std::isfinite(sample.speed) && std::isfinite(sample.yaw_rate) &&
         (!sample.pose || sample.pose->matrix().allFinite());
}

/// Part of `whole` between two fractions of its time.
OdometryStep partOf(const OdometryStep& whole, bool from_pose, double from, double to, double dt) {
  const double share = to - from;
  OdometryStep part{dt, whole.rotation * share, whole.forward * share, whole.left * share, whole.up * share};
  if (from_pose) {
    // A displacement measured as a chord is straight in space: only the axes it is told in turn with the
    // robot.
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
  if (!isFinite(sample)) return SampleVerdict::kNotFinite;
  if (last_ && sample.stamp == last_->stamp) return SampleVerdict::kRepeatedStamp;
  if (last_ && sample.stamp < last_->stamp) return SampleVerdict::kTimeWentBack;
  if (last_) {
    pending_.push_back(intervalTo(sample));
  } else {
    start_ = cursor_ = sample.stamp;
  }
  last_ = sample;
  return SampleVerdict::kAccepted;
}

OdometryTimeline::Interval OdometryTimeline::intervalTo(const OdometrySample& sample) const {
  Interval interval;
  interval.begin = last_->stamp;
  interval.end = sample.stamp;
  const double dt = secondsBetween(interval.begin, interval.end);
  interval.whole = {dt, sample.yaw_rate * dt, sample.speed * dt, 0.0, 0.0};
  interval.from_pose = use_pose_ && sample.pose && last_->pose;
  if (interval.from_pose) {
    const double yaw = yawOf(*sample.pose);
    const Eigen::Vector3d moved = sample.pose->translation() - last_->pose->translation();
    interval.whole.rotation = wrapAngle(yaw - yawOf(*last_->pose));
    interval.whole.forward = std::cos(yaw) * moved.x() + std::sin(yaw) * moved.y();
    interval.whole.left = -std::sin(yaw) * moved.x() + std::cos(yaw) * moved.y();
    interval.whole.up = moved.z();
  }
  return interval;
}

std::vector<TimedStep> OdometryTimeline::advanceTo(Stamp stamp) {
  std::vector<TimedStep> steps;
  while (!pending_.empty() && cursor_ < stamp) {
    const Interval& next = pending_.front();
    const Stamp end = std::min(stamp, next.end);
    if (cursor_ == next.begin && end == next.end) {
      steps.push_back({end, next.whole});
    } else {
      const double length = static_cast<double>(next.end - next.begin);
      steps.push_back(
          {end, partOf(next.whole, next.from_pose, static_cast<double>(cursor_ - next.begin) / length,
                       static_cast<double>(end - next.begin) / length, secondsBetween(cursor_, end))});
    }
    cursor_ = end;
    if (end == next.end) pending_.pop_front();
  }
  return steps;
}

void OdometryTimeline::reset() {
  start_.reset();
  last_.reset();
  pending_.clear();
  cursor_ = 0;
}

}  // namespace ratslam
