#include "ratslam/odometry/orb/orb_odometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ratslam/camera/grey.h"
#include "ratslam/common/angles.h"
#include "ratslam/common/params.h"
#include "ratslam/common/statistics.h"
#include "ratslam/odometry/orb/relocalisation.h"
#include "ratslam/odometry/uncertainty.h"
#include "ratslam/vision/triangulation.h"
#include "ratslam/vision/window_adjustment.h"

namespace ratslam {
namespace {

// The camera stands still if its image has moved by less than this since the last frame with motion [px]. It is
// several times the noise of an aligned patch. Slow motion adds up until it exceeds the bound.
constexpr double kStillPixels = 0.15;
// A landmark is removed if it is found in too few of the frames where it should be visible, or if no third keyframe
// observes it soon after its creation.
constexpr int kMinVisible = 4;
constexpr double kMinFoundShare = 0.3;
constexpr int kYoungKeyframes = 2;
constexpr std::size_t kMinObservations = 3;
// Standard deviation of the speed before the first measurement, if a camera height gives metres [m/s]; otherwise in
// median depths, which are the unit then.
constexpr double kUnknownSpeed = 10.0;
constexpr double kUnknownSpeedInDepths = 1.0;
// Factors for errors that a motion's covariance leaves out: landmarks count as exact while a pose is estimated
// (factor of the variance), and neighbouring measurements of the road are correlated (factor of the scale's standard
// deviation).
constexpr double kLandmarkErrors = 1.3;
constexpr double kRoadErrors = 1.7;

OrbOdometryParams validated(const OrbOdometryParams& params) {
  params.validate();
  return params;
}

CameraModel validated(const CameraModel& camera) {
  camera.validate();
  return camera;
}

ExtractorParams extractorParams(const OrbOdometryParams& params) {
  return {params.features, params.levels, params.scale_factor, params.fast_threshold,
          params.fast_min_threshold};
}

TrackingParams trackingParams(const OrbOdometryParams& params) {
  TrackingParams tracking;
  tracking.min_tracked = params.min_tracked;
  tracking.loss.gate = params.outlier_gate;
  return tracking;
}

ScaleParams scaleParams(const OrbOdometryParams& params) {
  ScaleParams scale;
  scale.camera_height = params.camera_height;
  return scale;
}

double unknownSpeed(const OrbOdometryParams& params) {
  if (params.camera_height > 0.0) return kUnknownSpeed;
  return params.nominal_speed > 0.0 ? params.nominal_speed : kUnknownSpeedInDepths;
}

/// An epoch from the first stamp: a source that starts anew has another first stamp.
std::uint32_t epochOf(Stamp first) {
  const auto bits = static_cast<std::uint64_t>(first);
  return static_cast<std::uint32_t>(bits ^ (bits >> 32));
}

}  // namespace

OrbOdometry::OrbOdometry(const CameraModel& camera, const OrbOdometryParams& params)
    : camera_(validated(camera)),
      params_(validated(params)),
      workers_(std::make_unique<WorkerPool>(params.threads)),
      extractor_params_(extractorParams(params)),
      extractor_(extractor_params_),
      tracking_params_(trackingParams(params)),
      initialiser_(camera, TwoViewParams{params.init_points, params.init_parallax_deg, 1.0},
                   params.map_keyframes),
      base_from_camera_(Eigen::Quaterniond(params.baseFromCamera().linear()).normalized()),
      camera_in_base_(params.baseFromCamera().translation()),
      scale_keeper_(scaleParams(params), base_from_camera_.conjugate() * -Eigen::Vector3d::UnitZ()),
      lens_refinement_(camera, LensRefinementParams{}),
      history_(unknownSpeed(params)) {}

cv::Mat OrbOdometry::checkedGrey(const cv::Mat& image) const {
  if (image.cols != camera_.width || image.rows != camera_.height) {
    throwBadValue("image size", std::to_string(image.cols) + "x" + std::to_string(image.rows),
                  "the camera's calibration is for " + std::to_string(camera_.width) + "x" +
                      std::to_string(camera_.height));
  }
  return eightBitGrey(image);
}

OrbResult OrbOdometry::track(Stamp stamp, const cv::Mat& image, ImageQuality quality) {
  const cv::Mat grey = checkedGrey(image);
  if (last_result_ && stamp <= last_result_->sample.stamp) {
    ++ignored_frames_;
    OrbResult again = *last_result_;
    again.twist.setZero();
    again.sample.speed = again.sample.yaw_rate = 0.0;
    again.sample.correction.reset();
    again.keyframe = again.restarted = false;
    again.ignored = true;
    return again;
  }
  OrbResult result;
  result.sample.stamp = stamp;
  std::shared_ptr<Frame> seen;
  if (quality == ImageQuality::kUsable) {
    seen = std::make_shared<Frame>(makeFrame(stamp, grey, camera_, extractor_, extractor_params_, *workers_));
    frame_ = seen;
  }
  if (!last_result_) {
    epoch_ = epochOf(stamp);
    bridge_.emplace(stamp, T_odom_camera_, seen);
    if (seen) initialiser_.add(seen);
  } else {
    const double dt = secondsBetween(last_result_->sample.stamp, stamp);
    const bool measured = seen && map_ && trackMap(result, dt);
    if (!measured) bridge(result, dt, seen);
  }
  result.sample.pose = inBase(T_odom_camera_);
  result.sample.epoch = epoch_;
  result.sample.unit = scale_keeper_.unit();
  result.state = state_;
  result.keyframes = map_ ? static_cast<int>(map_->keyframes().size()) : 0;
  result.landmarks = map_ ? static_cast<int>(map_->landmarks().size()) : 0;
  last_result_ = result;
  return result;
}

bool OrbOdometry::trackMap(OrbResult& result, double dt) {
  const Stamp stamp = frame_->stamp;
  const bool lost = bridge_ && !settling_;
  const RigidTransform predicted = lost ? bridge_->posePredicted(stamp, history_).inverse() * T_odom_world_
                                        : expTransform(velocity_ * dt) * lastPose();
  TrackingOutcome outcome =
      trackFrame(camera_, *map_, last_observations_, predicted, *frame_, tracking_params_, *workers_);
  if (!outcome.tracked) {
    outcome =
        relocalise(camera_, *map_, *frame_, params_.relocalisation_inliers, tracking_params_, *workers_);
  }
  if (!outcome.tracked) return false;
  state_ = OrbState::kTracking;
  initialiser_.reset();
  result.tracked_points = outcome.estimate.inliers;
  const bool still = standsStill();
  if (still) frame_->T_camera_world = lastPose();
  const Matrix6& covariance = outcome.estimate.covariance;
  if (lost) closeOnOldMap(result, dt, covariance);
  if (!still) {
    if (wantsKeyframe()) {
      takeKeyframe();
      result.keyframe = true;
    }
    still_reference_ = frame_->observations;
  }
  if (!lost) {
    // Motion since the last frame; exactly zero if the camera stands still.
    const RigidTransform step = still ? RigidTransform{} : lastPose() * frame_->T_camera_world.inverse();
    setMotion(result, step, dt, covarianceOfMotion(step, covariance));
    velocity_ = still ? Vector6(Vector6::Zero()) : logTransform(step.inverse()) / dt;
    history_.add(stamp, logTransform(step) / dt);
  }
  last_covariance_ = covariance;
  rememberPose();
  if (settling_) settleWhenReady(result);
  return true;
}

bool OrbOdometry::standsStill() const {
  // Both lists are in ascending order of landmarks.
  std::vector<double> moved;
  auto before = still_reference_.begin();
  for (const Observation& now : frame_->observations) {
    while (before != still_reference_.end() && before->landmark < now.landmark) ++before;
    if (before == still_reference_.end()) break;
    if (before->landmark == now.landmark) moved.push_back((before->pixel - now.pixel).norm());
  }
  if (static_cast<int>(moved.size()) < params_.min_tracked) return false;
  return median(std::move(moved)) < kStillPixels;
}

void OrbOdometry::rescale(double factor) {
  map_->rescale(factor, frame_->centre());
  T_reference_.translation *= factor;
  if (settling_) {
    for (Measured& sample : settling_->way) sample.T_reference.translation *= factor;
  }
  history_.rescale(factor);
}

bool OrbOdometry::wantsKeyframe() const {
  const Keyframe& newest = map_->keyframes().back();
  const double depth = map_->medianDepth(frame_->T_camera_world);
  const double baseline = (frame_->centre() - newest.frame->centre()).norm();
  return baseline > params_.keyframe_baseline * depth;
}

void OrbOdometry::takeKeyframe() {
  map_->addKeyframe(frame_, camera_);
  const KeyframeId newest = map_->keyframes().back().id;
  map_->removeLandmarks([&](const Landmark& landmark) {
    if (landmark.visible >= kMinVisible && landmark.found < kMinFoundShare * landmark.visible) return true;
    if (newest - landmark.created >= kYoungKeyframes && landmark.observations.size() < kMinObservations)
      return true;
    return false;
  });
  TriangulationParams triangulation;
  triangulation.min_parallax_deg = params_.min_parallax_deg;
  triangulation.max_new = params_.new_landmarks;
  addLandmarks(camera_, *map_, triangulation, *workers_);
  WindowParams window;
  window.free_keyframes = params_.window_keyframes;
  window.fixed_keyframes = params_.fixed_keyframes;
  adjustWindow(camera_, *map_, window, tracking_params_.loss);
  if (params_.ground_plane) {
    const auto factor = scale_keeper_.update(camera_, *map_);
    if (factor) rescale(*factor);
  }
  if (params_.refine_lens) refineLens();
}

void OrbOdometry::refineLens() {
  const auto better = lens_refinement_.update(camera_, *map_, tracking_params_.loss);
  if (!better) return;
  map_->recalibrate(camera_, *better);
  initialiser_.setCamera(*better);
  camera_ = *better;
}

void OrbOdometry::setMotion(OrbResult& result, const RigidTransform& step, double dt,
                            const Matrix6& covariance) const {
  const Vector6 twist = logTransform(step) / dt;
  result.twist.head<3>() = base_from_camera_ * twist.head<3>();
  result.twist.tail<3>() = base_from_camera_ * twist.tail<3>();
  if (!camera_in_base_.isZero(0.0)) {  // in turns a camera off the axis moves on an arc
    result.twist.head<3>() -= Eigen::Vector3d(result.twist.tail<3>()).cross(camera_in_base_);
  }
  result.sample.speed = result.twist(0);
  result.sample.yaw_rate = result.twist(5);
  result.covariance = bounded(inBase(covariance) / (dt * dt));
  result.sample.covariance = result.covariance;
}

Matrix6 OrbOdometry::covarianceOfUnit(const Eigen::Vector3d& way) const {
  const Eigen::Vector3d error = kRoadErrors * scale_keeper_.sigma() * way;
  Matrix6 covariance = Matrix6::Zero();
  covariance.topLeftCorner<3, 3>() = error * error.transpose();
  return covariance;
}

Matrix6 OrbOdometry::covarianceOfMotion(const RigidTransform& motion, const Matrix6& covariance) const {
  // Both poses come from the same landmarks, whose common error is that of the scale.
  return kLandmarkErrors * (covariance + last_covariance_) + covarianceOfUnit(motion.translation);
}

void OrbOdometry::rememberPose() {
  const Keyframe& newest = map_->keyframes().back();
  reference_ = newest.id;
  T_reference_ = frame_->T_camera_world * newest.frame->T_camera_world.inverse();
  T_odom_camera_ = T_odom_world_ * frame_->T_camera_world.inverse();
  last_observations_ = frame_->observations;
  measured_frame_ = frame_;
}

RigidTransform OrbOdometry::lastPose() const {
  return T_reference_ * map_->keyframe(reference_)->frame->T_camera_world;
}

Eigen::Isometry3d OrbOdometry::inBase(const RigidTransform& motion_of_camera) const {
  const RigidTransform C{base_from_camera_, camera_in_base_};
  return (C * motion_of_camera * C.inverse()).isometry();
}

Matrix6 OrbOdometry::inBase(const Matrix6& covariance) const {
  Matrix6 adjoint = Matrix6::Zero();
  adjoint.topLeftCorner<3, 3>() = base_from_camera_.toRotationMatrix();
  adjoint.bottomRightCorner<3, 3>() = adjoint.topLeftCorner<3, 3>();
  if (!camera_in_base_.isZero(0.0)) {
    adjoint.topRightCorner<3, 3>() = skew(camera_in_base_) * adjoint.topLeftCorner<3, 3>();
  }
  return adjoint * covariance * adjoint.transpose();
}

std::vector<Eigen::Vector3d> OrbOdometry::landmarkPositions() const {
  std::vector<Eigen::Vector3d> positions;
  if (!map_) return positions;
  for (const Landmark& landmark : map_->landmarks()) {
    positions.push_back(base_from_camera_ * (T_odom_world_ * landmark.position) + camera_in_base_);
  }
  return positions;
}

}  // namespace ratslam
