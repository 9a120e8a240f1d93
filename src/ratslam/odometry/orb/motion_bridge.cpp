#include "ratslam/odometry/orb/motion_bridge.h"

#include <algorithm>
#include <cmath>

namespace ratslam {

UncertainMotion compose(const UncertainMotion& a, const UncertainMotion& b) {
  UncertainMotion both;
  both.motion = a.motion * b.motion;
  const Eigen::Matrix3d turn = a.motion.rotation.toRotationMatrix();
  Matrix6 by_a = Matrix6::Identity();
  by_a.topRightCorner<3, 3>() = -skew(turn * b.motion.translation);
  Matrix6 by_b = Matrix6::Zero();
  by_b.topLeftCorner<3, 3>() = by_b.bottomRightCorner<3, 3>() = turn;
  both.covariance = by_a * a.covariance * by_a.transpose() + by_b * b.covariance * by_b.transpose();
  return both;
}

UncertainMotion MotionBridge::predict(Stamp stamp, const MotionHistory& history) const {
  const double begin = way_.empty() ? 0.0 : lasts(way_.back().stamp);
  return history.predict(begin, lasts(stamp));
}

UncertainMotion MotionBridge::add(const CameraModel& camera, Stamp stamp, std::shared_ptr<const Frame> frame,
                                  const MotionHistory& history) {
  UncertainMotion step = predict(stamp, history);
  RigidTransform pose = lastPose() * step.motion;
  if (frame && last_frame_) {
    if (const auto view = compareFarFeatures(camera, *last_frame_, *frame)) {
      pose.rotation = (last_frame_pose_.rotation * view->T_after_before.rotation.conjugate()).normalized();
      step.motion.rotation = (lastPose().rotation.conjugate() * pose.rotation).normalized();
      step.covariance.bottomRightCorner<3, 3>() =
          view->rotation_sigma * view->rotation_sigma * Eigen::Matrix3d::Identity();
    }
  }
  if (frame) {
    last_frame_ = std::move(frame);
    last_frame_pose_ = pose;
  }
  way_.push_back({stamp, pose});
  return step;
}

RigidTransform MotionBridge::poseAt(Stamp stamp) const {
  if (stamp == from_.stamp) return from_.pose;
  const auto found = std::find_if(way_.begin(), way_.end(),
                                  [&](const StampedPoseOfCamera& sample) { return sample.stamp == stamp; });
  return found == way_.end() ? lastPose() : found->pose;
}

UncertainMotion MotionBridge::motionTo(const CameraModel& camera, const Frame& frame,
                                       const Vector6& twist_after, const MotionHistory& history) const {
  const double duration = lasts(frame.stamp);
  if (duration <= 0.0) return {};
  const bool known_before = !history.empty();
  UncertainMotion motion =
      history.between(known_before ? history.twist() : twist_after, twist_after, duration);
  if (!known_before) motion.covariance *= 4.0;  // a random walk known at one end only
  const auto view = before_ ? compareFarFeatures(camera, *before_, frame) : std::nullopt;
  if (!view) return motion;
  const RigidTransform seen = view->T_after_before.inverse();
  const double along = motion.motion.translation.norm();
  const Eigen::Vector3d old_ahead =
      along > 1e-9 ? Eigen::Vector3d(motion.motion.translation / along) : Eigen::Vector3d::UnitZ();
  const double along_variance = old_ahead.dot(motion.covariance.topLeftCorner<3, 3>() * old_ahead);
  const Eigen::Vector3d ahead = seen.translation.normalized();
  const double across = std::pow(view->direction_sigma * along, 2);
  motion.motion = {seen.rotation, along * ahead};
  motion.covariance.setZero();
  motion.covariance.topLeftCorner<3, 3>() =
      across * Eigen::Matrix3d::Identity() + along_variance * ahead * ahead.transpose();
  motion.covariance.bottomRightCorner<3, 3>() =
      view->rotation_sigma * view->rotation_sigma * Eigen::Matrix3d::Identity();
  return motion;
}

std::vector<StampedPoseOfCamera> MotionBridge::wayTo(Stamp stamp, const RigidTransform& predicted,
                                                     const RigidTransform& motion,
                                                     const Vector6& twist_after) const {
  const RigidTransform back = from_.pose.inverse();
  const Vector6 shift = logTransform((back * predicted).inverse() * motion);
  const double duration = lasts(stamp);
  std::vector<StampedPoseOfCamera> way;
  for (const StampedPoseOfCamera& sample : way_) {
    if (sample.stamp > stamp) {
      const double after = secondsBetween(stamp, sample.stamp);
      way.push_back({sample.stamp, motion * expTransform(after * twist_after)});
    } else {
      const double share = duration > 0.0 ? lasts(sample.stamp) / duration : 1.0;
      way.push_back({sample.stamp, back * sample.pose * expTransform(share * shift)});
    }
  }
  return way;
}

}  // namespace ratslam
