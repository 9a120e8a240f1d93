// Unmeasured stretches of the odometry: the start of maps and the stretches between maps.
#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"
#include "ratslam/odometry/orb/looking_back.h"
#include "ratslam/odometry/orb/orb_odometry.h"

namespace ratslam {
namespace {

// Assumed median depth of a street scene, if the camera height is known but no road has been seen yet [camera
// heights].
constexpr double kDepthInHeights = 10.0;
constexpr double kGuessSigma = 0.5;        // standard deviation of the log of that guess
constexpr double kFirstRotationDeg = 0.1;  // standard deviation of the rotation between a map's first frames
constexpr double kFirstWay = 0.02;  // the same of the translation, in all axes, as a share of its length
constexpr std::size_t kSettledKeyframes = 10;  // with so many keyframes a map's first poses are known well
constexpr double kSettledScale = 0.1;          // with this standard deviation of the log scale waiting ends
constexpr double kTwistOver = 0.2;             // time over which a twist is averaged [s]
constexpr int kLeastLookingBack = 25;          // inliers that an earlier frame must have
// Factor of an earlier frame's pose covariance, because it sees the landmarks from farther away.
constexpr double kLookingBackGrowth = 4.0;

}  // namespace

bool OrbOdometry::mayStartAnew(Stamp stamp) const {
  return !map_ || bridge_->lasts(stamp) > params_.coast_time + params_.relocalisation_time;
}

bool OrbOdometry::startMap(OrbResult& result, const MotionBridge::Step& step) {
  const auto& reference = initialiser_.reference();
  auto initial =
      initialiser_.add(frame_, reference ? bridge_->turnSince(reference->stamp, step) : std::nullopt);
  if (!initial || !mayStartAnew(frame_->stamp)) return false;
  adoptMap(std::move(*initial), result);
  return true;
}

void OrbOdometry::adoptMap(InitialMap initial, OrbResult& result) {
  const Frame& first = *initial.first;
  const double elapsed = secondsBetween(first.stamp, frame_->stamp);
  result.restarted = map_.has_value();
  restarts_ += result.restarted ? 1 : 0;
  map_ = std::move(initial.map);
  map_->rescale(scaleOfNewMap(elapsed), Eigen::Vector3d::Zero());
  state_ = OrbState::kTracking;
  result.keyframe = true;
  result.tracked_points = static_cast<int>(frame_->observations.size());

  velocity_ = logTransform(frame_->T_camera_world) / elapsed;
  const Vector6 twist = -velocity_;
  settling_.emplace(Settling{history_, {}});
  T_odom_world_ = bridge_->startPose() * bridge_->motionTo(camera_, first, twist, history_, *workers_).motion;
  last_covariance_.setZero();
  const double dt = secondsBetween(last_result_->sample.stamp, frame_->stamp);
  UncertainMotion step{expTransform(twist * dt), Matrix6::Zero()};
  step.covariance = covarianceOfNewMap(step.motion.translation);
  setMotion(result, step.motion, dt, step.covariance);
  history_.interrupt();
  history_.add(frame_->stamp, twist);
  still_reference_.clear();
  rememberPose();
  settling_->way.push_back({frame_->stamp, reference_, T_reference_});
  initialiser_.reset();
}

Matrix6 OrbOdometry::covarianceOfNewMap(const Eigen::Vector3d& way) const {
  Matrix6 covariance = Matrix6::Zero();
  covariance.topLeftCorner<3, 3>() = std::pow(kFirstWay * way.norm(), 2) * Eigen::Matrix3d::Identity() +
                                     std::pow(scale_keeper_.sigma(), 2) * way * way.transpose();
  covariance.bottomRightCorner<3, 3>() =
      std::pow(degreesToRadians(kFirstRotationDeg), 2) * Eigen::Matrix3d::Identity();
  return covariance;
}

void OrbOdometry::settleWhenReady(OrbResult& result) {
  settling_->way.push_back({frame_->stamp, reference_, T_reference_});
  const std::size_t keyframes = map_->keyframes().size();
  const bool scale_known = !params_.ground_plane || scale_keeper_.sigma() < kSettledScale;
  if (scale_keeper_.locked() || map_->full() || (keyframes >= kSettledKeyframes && scale_known))
    settle(result);
}

void OrbOdometry::settle(OrbResult& result) {
  const Frame& first = *map_->keyframes().front().frame;
  // Poses of the camera in the map's world frame.
  std::vector<StampedPoseOfCamera> known{{first.stamp, first.T_camera_world.inverse()}};
  for (const Measured& sample : settling_->way) {
    const RigidTransform& T_keyframe_world = map_->keyframe(sample.reference)->frame->T_camera_world;
    known.push_back({sample.stamp, (sample.T_reference * T_keyframe_world).inverse()});
  }
  const auto twist_from_first = [&] {
    const auto later = std::find_if(known.begin(), known.end() - 1, [&](const StampedPoseOfCamera& place) {
      return secondsBetween(first.stamp, place.stamp) >= kTwistOver;
    });
    return Vector6(logTransform(first.T_camera_world * later->pose) /
                   secondsBetween(first.stamp, later->stamp));
  };
  const auto located = lookBack(camera_, *map_, bridge_->frames(), -twist_from_first(),
                                {tracking_params_, kLeastLookingBack}, *workers_);
  for (const LocatedFrame& frame : located)
    known.push_back({frame.stamp, frame.estimate.T_camera_world.inverse()});
  std::sort(known.begin(), known.end(), [](const auto& a, const auto& b) { return a.stamp < b.stamp; });

  const Vector6 after = twist_from_first();
  const Vector6 before = settling_->before.empty() ? after : settling_->before.twist();
  UncertainMotion to_first = bridge_->motionTo(camera_, first, after, settling_->before, *workers_);
  std::optional<PoseEstimate> start;
  if (!located.empty() && located.front().stamp == bridge_->from()) {
    start = located.front().estimate;
  } else if (first.stamp != bridge_->from() && bridge_->before()) {
    start = findAlong(camera_, *map_, *bridge_->before(), to_first, {tracking_params_, kLeastLookingBack},
                      *workers_);
  }
  if (start || first.stamp == bridge_->from()) {
    const RigidTransform T_start_world = start ? start->T_camera_world : first.T_camera_world;
    to_first.motion = T_start_world * first.T_camera_world.inverse();
    to_first.covariance = covarianceOfNewMap(to_first.motion.translation);
    if (start) to_first.covariance += kLookingBackGrowth * start->covariance;
  }
  if (known.front().stamp == bridge_->from()) known.erase(known.begin());
  const RigidTransform T_start_world = to_first.motion * first.T_camera_world;
  UncertainMotion since_first{first.T_camera_world * known.back().pose, Matrix6::Zero()};
  since_first.covariance = covarianceOfNewMap(since_first.motion.translation);
  for (StampedPoseOfCamera& place : known) place.pose = T_start_world * place.pose;

  T_odom_world_ = bridge_->startPose() * T_start_world;
  T_odom_camera_ = bridge_->startPose() * known.back().pose;
  setCorrection(result, known.back().stamp, compose(to_first, since_first),
                bridge_->layOut(known, before, after));
  settling_.reset();
}

double OrbOdometry::scaleOfNewMap(double elapsed) {
  if (params_.ground_plane) {
    if (const auto by_road = scale_keeper_.scaleOfNewMap(camera_, *map_)) return *by_road;
  }
  const double way = frame_->T_camera_world.translation.norm();
  if (!history_.empty()) {
    const double speed = history_.twist().head<3>().norm();
    const double sigma = std::sqrt(history_.speedDiffusion() * bridge_->lasts(frame_->stamp));
    if (speed > sigma) {
      scale_keeper_.scaleGiven(sigma / speed);
      return speed * elapsed / way;
    }
  }
  if (params_.camera_height > 0.0) {
    scale_keeper_.scaleGiven(kGuessSigma);
    return kDepthInHeights * params_.camera_height;
  }
  scale_keeper_.scaleGiven(0.0);  // the first map defines the unit
  return params_.nominal_speed > 0.0 ? params_.nominal_speed * elapsed / way : 1.0;
}

void OrbOdometry::bridge(OrbResult& result, double dt, const std::shared_ptr<Frame>& seen) {
  if (settling_) settle(result);  // with the samples so far
  if (!bridge_) bridge_.emplace(last_result_->sample.stamp, T_odom_camera_, measured_frame_);
  const Stamp stamp = result.sample.stamp;
  const MotionBridge::Step step = bridge_->look(camera_, stamp, seen.get(), history_, *workers_);
  if (seen && startMap(result, step)) return;
  bridge_->add(step, seen);
  if (map_) {
    state_ = bridge_->lasts(stamp) <= params_.coast_time ? OrbState::kLost : OrbState::kRelocalising;
  }
  T_odom_camera_ = bridge_->lastPose();
  if (seen) seen->T_camera_world = T_odom_camera_.inverse() * T_odom_world_;
  // The unit of length is as uncertain as while the way was measured.
  setMotion(result, step.motion.motion, dt,
            step.motion.covariance + covarianceOfUnit(step.motion.motion.translation));
  result.sample.bridged = true;
}

void OrbOdometry::closeOnOldMap(OrbResult& result, double dt, const Matrix6& covariance) {
  const RigidTransform start = bridge_->startPose().inverse();
  UncertainMotion whole{start * T_odom_world_ * frame_->T_camera_world.inverse(), Matrix6::Zero()};
  whole.covariance = covarianceOfMotion(whole.motion, covariance);
  const Stamp stamp = frame_->stamp;
  const Vector6 twist = history_.twist();
  const auto way = bridge_->layOut({{stamp, whole.motion}}, twist, twist);
  const RigidTransform step = way.empty() ? whole.motion : way.back().pose.inverse() * whole.motion;
  setCorrection(result, stamp, whole, way);
  setMotion(result, step, dt, whole.covariance);
  velocity_ = logTransform(step.inverse()) / dt;
}

void OrbOdometry::setCorrection(OrbResult& result, Stamp to, const UncertainMotion& whole,
                                const std::vector<StampedPoseOfCamera>& way) {
  OdometryCorrection correction;
  correction.from = bridge_->from();
  correction.to = to;
  correction.motion = inBase(whole.motion);
  correction.covariance = inBase(whole.covariance);
  for (const StampedPoseOfCamera& sample : way) correction.way.push_back({sample.stamp, inBase(sample.pose)});
  result.sample.correction = std::move(correction);
  bridge_.reset();
}

}  // namespace ratslam
