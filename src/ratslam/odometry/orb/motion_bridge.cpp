#include "ratslam/odometry/orb/motion_bridge.h"

#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

constexpr double kFarApart = 0.5;           // [s]
constexpr std::ptrdiff_t kMostFrames = 40;  // kept: an image pyramid is large

}  // namespace

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
                                  const MotionHistory& history, WorkerPool& workers) {
  UncertainMotion step = predict(stamp, history);
  RigidTransform pose = lastPose() * step.motion;
  if (frame && last_frame_) {
    UncertainMotion since = history.predict(0.0, secondsBetween(last_frame_->stamp, stamp));
    since.motion = last_frame_pose_.inverse() * pose;
    const bool far = secondsBetween(last_frame_->stamp, stamp) > kFarApart;
    if (const auto view = compareFarFeatures(camera, *last_frame_, *frame, since, far, workers)) {
      pose.rotation = (last_frame_pose_.rotation * view->motion.motion.rotation).normalized();
      step.motion.rotation = (lastPose().rotation.conjugate() * pose.rotation).normalized();
      step.covariance.bottomRightCorner<3, 3>() = view->motion.covariance.bottomRightCorner<3, 3>();
    }
  }
  if (frame) {
    last_frame_ = frame;
    last_frame_pose_ = pose;
  }
  way_.push_back({stamp, pose, std::move(frame)});
  thinOutFrames();
  return step;
}

RigidTransform MotionBridge::poseAt(Stamp stamp) const {
  if (stamp == from_.stamp) return from_.pose;
  const auto found =
      std::find_if(way_.begin(), way_.end(), [&](const Sample& sample) { return sample.stamp == stamp; });
  return found == way_.end() ? lastPose() : found->pose;
}

UncertainMotion MotionBridge::motionTo(const CameraModel& camera, const Frame& frame,
                                       const Vector6& twist_after, const MotionHistory& history,
                                       WorkerPool& workers) const {
  const double duration = lasts(frame.stamp);
  if (duration <= 0.0) return {};
  const bool known_before = !history.empty();
  UncertainMotion motion =
      history.between(known_before ? history.twist() : twist_after, twist_after, duration);
  if (!known_before) motion.covariance *= 4.0;  // a random walk known at one end only
  const auto view =
      before_ ? compareFarFeatures(camera, *before_, frame, motion, true, workers) : std::nullopt;
  if (!view) return motion;
  const double along = motion.motion.translation.norm();
  if (!(along > 0.0)) return motion;
  const Eigen::Vector3d ahead = motion.motion.translation / along;
  const double variance = ahead.dot(motion.covariance.topLeftCorner<3, 3>() * ahead);
  UncertainMotion seen = view->motion;
  const Eigen::Vector3d direction = seen.motion.translation;
  seen.motion.translation *= along;
  Matrix6 scaling = Matrix6::Identity();
  scaling.topLeftCorner<3, 3>() *= along;
  seen.covariance = scaling * seen.covariance * scaling;
  seen.covariance.topLeftCorner<3, 3>() += variance * direction * direction.transpose();
  return seen;
}

std::vector<std::shared_ptr<const Frame>> MotionBridge::frames() const {
  std::vector<std::shared_ptr<const Frame>> frames;
  if (before_) frames.push_back(before_);
  for (const Sample& sample : way_) {
    if (sample.frame) frames.push_back(sample.frame);
  }
  return frames;
}

void MotionBridge::thinOutFrames() {
  const auto kept = [](const Sample& sample) { return sample.frame != nullptr; };
  if (std::count_if(way_.begin(), way_.end(), kept) <= kMostFrames) return;
  bool drop = false;
  for (Sample& sample : way_) {
    if (!sample.frame) continue;
    if (drop) sample.frame.reset();
    drop = !drop;
  }
}

std::vector<StampedPoseOfCamera> MotionBridge::layOut(const std::vector<StampedPoseOfCamera>& known,
                                                      const Vector6& before, const Vector6& after) const {
  // A course of evenly changing speed, relative to the start, at the stamps of samples and known places.
  const double whole = lasts(known.back().stamp);
  const auto course = [&](const RigidTransform& from, double begin, double end) {
    const double middle = whole > 0.0 ? 0.5 * (begin + end) / whole : 1.0;
    return from * expTransform((end - begin) * ((1.0 - middle) * before + middle * after));
  };
  std::vector<StampedPoseOfCamera> way;
  std::size_t sample = 0;
  StampedPoseOfCamera last{from_.stamp, RigidTransform{}};
  for (const StampedPoseOfCamera& place : known) {
    // The course from the last known place to this one, then bent so that it ends there.
    const std::size_t first = way.size();
    double time = lasts(last.stamp);
    RigidTransform pose = last.pose;
    for (; sample < way_.size() && way_[sample].stamp < place.stamp; ++sample) {
      const double now = lasts(way_[sample].stamp);
      pose = course(pose, time, now);
      time = now;
      way.push_back({way_[sample].stamp, pose});
    }
    pose = course(pose, time, lasts(place.stamp));
    const Vector6 shift = logTransform(pose.inverse() * place.pose);
    const double duration = secondsBetween(last.stamp, place.stamp);
    for (std::size_t i = first; i < way.size(); ++i) {
      const double share = secondsBetween(last.stamp, way[i].stamp) / duration;
      way[i].pose = way[i].pose * expTransform(share * shift);
    }
    if (sample < way_.size() && way_[sample].stamp == place.stamp) ++sample;
    way.push_back(place);
    last = place;
  }
  way.pop_back();  // the end is no sample in between
  return way;
}

}  // namespace ratslam
