#include "ratslam_ros/support/odometry_frame.h"

#include <cmath>

#include "ratslam/common/angles.h"
#include "ratslam/odometry/uncertainty.h"

namespace ratslam {
namespace {

/// Bound on kept samples: 16 minutes at 100 Hz.
constexpr std::size_t kMostEntries = 100000;

Eigen::Isometry3d levelPose(double x, double y, double z, double yaw) {
  return Eigen::Translation3d(x, y, z) * Eigen::Isometry3d(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
}

RelativePose poseOf(const Eigen::Isometry3d& pose) {
  return {pose.translation().x(), pose.translation().y(), pose.translation().z(), yawOf(pose)};
}

bool isFinite(const RelativePose& pose) {
  return std::isfinite(pose.x) && std::isfinite(pose.y) && std::isfinite(pose.z) && std::isfinite(pose.yaw);
}

}  // namespace

void OdometryFrame::follow(const DecidedSample& decided) {
  if (decided.verdict == SampleVerdict::kAccepted || decided.verdict == SampleVerdict::kTimeWentBack) {
    add(decided.sample);
  }
}

void OdometryFrame::add(const OdometrySample& sample) {
  if (!entries_.empty() && sample.stamp == entries_.back().stamp) return;
  RelativePose pose;
  if (sample.pose) {
    pose = poseOf(*sample.pose);
  } else if (!entries_.empty()) {
    const double dt = std::max(0.0, secondsBetween(entries_.back().stamp, sample.stamp));
    Motion motion;
    motion.pose = entries_.back().pose;
    OdometryStep step;
    step.rotation = sample.yaw_rate * dt;
    step.forward = sample.speed * dt;
    motion.add(step);
    pose = motion.pose;
  }
  if (!isFinite(pose)) return;
  if (!entries_.empty() && sample.stamp < entries_.back().stamp) entries_.clear();
  entries_.push_back({sample.stamp, pose});
  if (entries_.size() > kMostEntries) entries_.pop_front();
}

std::optional<RelativePose> OdometryFrame::poseAt(Stamp stamp) {
  if (entries_.empty() || stamp < entries_.front().stamp || stamp > entries_.back().stamp)
    return std::nullopt;
  while (entries_.size() > 1 && entries_[1].stamp <= stamp) entries_.pop_front();
  const Entry& before = entries_.front();
  if (before.stamp == stamp) return before.pose;
  const Entry& after = entries_[1];
  const double share = secondsBetween(before.stamp, stamp) / secondsBetween(before.stamp, after.stamp);
  const auto blend = [share](double a, double b) { return a + share * (b - a); };
  return RelativePose{blend(before.pose.x, after.pose.x), blend(before.pose.y, after.pose.y),
                      blend(before.pose.z, after.pose.z),
                      wrapAngle(before.pose.yaw + share * wrapAngle(after.pose.yaw - before.pose.yaw))};
}

Eigen::Isometry3d mapToOdom(const MapPose& robot_in_map, const RelativePose& robot_in_odom) {
  return levelPose(robot_in_map.x, robot_in_map.y, robot_in_map.z, robot_in_map.yaw) *
         levelPose(robot_in_odom.x, robot_in_odom.y, robot_in_odom.z, robot_in_odom.yaw).inverse();
}

}  // namespace ratslam
