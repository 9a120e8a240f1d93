// The parts of the odometry that deal with what was not measured: the start of maps and the stretches between
// them.
#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"
#include "ratslam/odometry/orb/orb_odometry.h"

namespace ratslam {
namespace {

// Median depth of a street scene, where a camera height is known but no road has been seen yet [camera
// heights].
constexpr double kDepthInHeights = 10.0;
constexpr double kGuessSigma = 0.5;        // of the log of that guess
constexpr double kFirstRotationDeg = 0.1;  // standard deviation of the rotation across a map's first frames
constexpr double kFirstWay = 0.02;         // the same of the way, sideways and lengthways, of its length

}  // namespace

bool OrbOdometry::mayStartAnew(Stamp stamp) const {
  return !map_ || bridge_->lasts(stamp) > params_.coast_time + params_.relocalisation_time;
}

bool OrbOdometry::startMap(OrbResult& result) {
  auto initial = initialiser_.add(frame_);
  // A map needs two frames after the last measured one, so that the bridge is open by now.
  if (!initial || !bridge_ || !mayStartAnew(frame_->stamp)) return false;
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

  const RigidTransform since_first = frame_->T_camera_world.inverse();
  const Eigen::Vector3d& way = since_first.translation;
  UncertainMotion measured{since_first, Matrix6::Zero()};
  measured.covariance.topLeftCorner<3, 3>() =
      std::pow(kFirstWay * way.norm(), 2) * Eigen::Matrix3d::Identity() +
      std::pow(scale_keeper_.sigma(), 2) * way * way.transpose();
  measured.covariance.bottomRightCorner<3, 3>() =
      std::pow(degreesToRadians(kFirstRotationDeg), 2) * Eigen::Matrix3d::Identity();

  const Vector6 twist = logTransform(since_first) / elapsed;
  const UncertainMotion before = bridge_->motionTo(camera_, first, twist, history_);
  T_odom_world_ = bridge_->startPose() * before.motion;
  setCorrection(result, compose(before, measured),
                bridge_->wayTo(first.stamp, bridge_->poseAt(first.stamp), before.motion, twist));
  const double dt = secondsBetween(last_result_->sample.stamp, frame_->stamp);
  setMotion(result, expTransform(twist * dt), dt, measured.covariance * (dt * dt) / (elapsed * elapsed));
  velocity_ = logTransform(frame_->T_camera_world) / elapsed;
  history_.interrupt();
  history_.add(frame_->stamp, twist);
  last_covariance_.setZero();
  still_reference_.clear();
  rememberPose();
  initialiser_.reset();
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
  scale_keeper_.scaleGiven(0.0);  // the unit is whatever the first map makes it
  return params_.nominal_speed > 0.0 ? params_.nominal_speed * elapsed / way : 1.0;
}

void OrbOdometry::bridge(OrbResult& result, double dt, const std::shared_ptr<Frame>& seen) {
  if (!bridge_) bridge_.emplace(last_result_->sample.stamp, T_odom_camera_, measured_frame_);
  const Stamp stamp = result.sample.stamp;
  const UncertainMotion step = bridge_->add(camera_, stamp, seen, history_);
  if (map_) {
    state_ = bridge_->lasts(stamp) <= params_.coast_time ? OrbState::kLost : OrbState::kRelocalising;
  }
  T_odom_camera_ = bridge_->lastPose();
  if (seen) seen->T_camera_world = T_odom_camera_.inverse() * T_odom_world_;
  setMotion(result, step.motion, dt, step.covariance);
  result.sample.bridged = true;
}

void OrbOdometry::closeOnOldMap(OrbResult& result, double dt, const Matrix6& covariance) {
  const RigidTransform start = bridge_->startPose().inverse();
  UncertainMotion whole{start * T_odom_world_ * frame_->T_camera_world.inverse(), Matrix6::Zero()};
  whole.covariance = covarianceOfMotion(whole.motion, covariance);
  const Stamp stamp = frame_->stamp;
  const auto way =
      bridge_->wayTo(stamp, bridge_->posePredicted(stamp, history_), whole.motion, Vector6::Zero());
  const RigidTransform step = way.empty() ? whole.motion : way.back().pose.inverse() * whole.motion;
  setCorrection(result, whole, way);
  setMotion(result, step, dt, whole.covariance);
  velocity_ = logTransform(step.inverse()) / dt;
}

void OrbOdometry::setCorrection(OrbResult& result, const UncertainMotion& whole,
                                const std::vector<StampedPoseOfCamera>& way) {
  OdometryCorrection correction;
  correction.from = bridge_->from();
  correction.to = result.sample.stamp;
  correction.motion = inBase(whole.motion);
  correction.covariance = inBase(whole.covariance);
  for (const StampedPoseOfCamera& sample : way) correction.way.push_back({sample.stamp, inBase(sample.pose)});
  result.sample.correction = std::move(correction);
  bridge_.reset();
}

}  // namespace ratslam
