#include "ratslam/experience_map/trajectory.h"

#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

constexpr double kFirstTolerance = 1e-3;

/// Distance of a pose from the interpolation between `a` and `b` at its stamp [m, rad].
double deviation(const StampedPose& pose, const StampedPose& a, const StampedPose& b) {
  const double share = secondsBetween(a.stamp, pose.stamp) / secondsBetween(a.stamp, b.stamp);
  const auto off = [share](double at, double from, double to) { return at - (from + share * (to - from)); };
  const double yaw = wrapAngle(pose.pose.yaw - (a.pose.yaw + share * wrapAngle(b.pose.yaw - a.pose.yaw)));
  return std::max({std::abs(off(pose.pose.x, a.pose.x, b.pose.x)),
                   std::abs(off(pose.pose.y, a.pose.y, b.pose.y)),
                   std::abs(off(pose.pose.z, a.pose.z, b.pose.z)), std::abs(yaw)});
}

}  // namespace

void Trajectory::record(Stamp stamp, std::uint32_t frame, const RelativePose& relative, const MapPose& online,
                        const Eigen::Quaterniond& tilt) {
  if (!samples_.empty() && samples_.back().stamp == stamp) {
    samples_.back() = {stamp, frame, relative, tilt};
    online_.back() = {stamp, online, tilt};
    return;
  }
  samples_.push_back({stamp, frame, relative, tilt});
  online_.push_back({stamp, online, tilt});
  if (most_ > 0 && samples_.size() > most_) thin();
}

void Trajectory::retie(Stamp since, const RelativePose& robot_before, std::uint32_t frame,
                       const RelativePose& robot) {
  const auto as_map_pose = [](const RelativePose& pose) {
    return MapPose{pose.x, pose.y, pose.z, pose.yaw, 0.0};
  };
  for (std::size_t k = samples_.size(); k-- > 0 && samples_[k].stamp >= since;) {
    Sample& sample = samples_[k];
    const RelativePose from_robot = between(as_map_pose(robot_before), as_map_pose(sample.relative));
    sample.relative = between(MapPose{}, compose(as_map_pose(robot), from_robot));
    sample.frame = frame;
    if (k > 0 && samples_[k - 1].stamp > sample.stamp) break;  // stamps have gone back
  }
}

/// Whether interpolation between samples `a` and `b` gives those in between. Three of them are checked.
bool Trajectory::toldBy(std::size_t a, std::size_t b) const {
  if (online_[b].stamp <= online_[a].stamp) return false;
  for (std::size_t quarter = 1; quarter <= 3; ++quarter) {
    const std::size_t k = a + std::max<std::size_t>((b - a) * quarter / 4, 1);
    if (k < b && !(deviation(online_[k], online_[a], online_[b]) <= tolerance_)) return false;
  }
  return true;
}

/// Thins once with the present tolerance. If too many poses are left, the next sample starts the next pass.
void Trajectory::thin() {
  tolerance_ = tolerance_ > 0.0 ? tolerance_ : kFirstTolerance;
  const std::size_t end = samples_.size() - samples_.size() / 4;
  std::size_t kept = 0;  // new index of the last sample kept; those after it have not moved yet
  std::size_t last = 0;  // old index of the last sample kept
  for (std::size_t k = 1; k < samples_.size(); ++k) {
    if (k < end && toldBy(last, k + 1)) continue;
    ++kept;
    last = k;
    samples_[kept] = samples_[k];
    online_[kept] = online_[k];
  }
  samples_.resize(kept + 1);
  online_.resize(kept + 1);
  if (samples_.size() > most_ - most_ / 4) tolerance_ *= 2.0;
}

std::optional<std::size_t> Trajectory::indexAt(Stamp stamp) const {
  for (std::size_t k = samples_.size(); k-- > 0;) {
    if (samples_[k].stamp <= stamp) return k;
    if (k > 0 && samples_[k - 1].stamp > samples_[k].stamp) return std::nullopt;
  }
  return std::nullopt;
}

void Trajectory::rebase(const MapPose& origin, const MapPose& first) {
  for (Sample& sample : samples_) sample.relative = between(first, compose(origin, sample.relative));
}

}  // namespace ratslam
