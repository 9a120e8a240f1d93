#include "ratslam/odometry/orb/orb_odometry.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "ratslam/common/angles.h"
#include "ratslam/common/params.h"
#include "ratslam/odometry/orb/relocalisation.h"
#include "ratslam/vision/triangulation.h"
#include "ratslam/vision/window_adjustment.h"

namespace ratslam {
namespace {

// Median depth of a street scene, where a camera height is known but no road has been seen yet [camera
// heights].
constexpr double kDepthInHeights = 10.0;
// A camera whose image has moved less than this since it last moved stands still [px]; several times the
// noise of an aligned patch. Slow motion is not lost: it adds up until it shows.
constexpr double kStillPixels = 0.15;
// A landmark goes when it is found too rarely where it should be seen, or when it has not been confirmed by a
// third keyframe soon after it was made.
constexpr int kMinVisible = 4;
constexpr double kMinFoundShare = 0.3;
constexpr int kYoungKeyframes = 2;
constexpr std::size_t kMinObservations = 3;
constexpr double kCoastingGrowth = 10.0;  // of the standard deviation, per second of coasting

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

/// Camera axes (x right, y down, z forward) in base_link, for a camera that looks down by `pitch` [rad].
Eigen::Quaterniond cameraInBase(double pitch) {
  Eigen::Matrix3d level;
  level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return Eigen::Quaterniond(Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) * level).normalized();
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
      base_from_camera_(cameraInBase(degreesToRadians(params.camera_pitch_deg))),
      scale_keeper_(scaleParams(params), base_from_camera_.conjugate() * -Eigen::Vector3d::UnitZ()),
      lens_refinement_(camera, LensRefinementParams{}) {}

cv::Mat OrbOdometry::checkedGrey(const cv::Mat& image) const {
  if (image.cols != camera_.width || image.rows != camera_.height) {
    throwBadValue("image size", std::to_string(image.cols) + "x" + std::to_string(image.rows),
                  "the camera's calibration is for " + std::to_string(camera_.width) + "x" +
                      std::to_string(camera_.height));
  }
  if (image.type() == CV_8UC1) return image;
  if (image.type() != CV_8UC3)
    throwBadValue("image type", image.type(), "it must have 8 bits and 1 or 3 channels");
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

OrbResult OrbOdometry::track(Stamp stamp, const cv::Mat& image) {
  const cv::Mat grey = checkedGrey(image);
  OrbResult result;
  if (last_result_ && stamp <= last_result_->sample.stamp) {
    ++ignored_frames_;
    result = *last_result_;
    result.twist.setZero();
    result.sample.speed = result.sample.yaw_rate = 0.0;
    result.keyframe = result.restarted = false;
    result.ignored = true;
    return result;
  }
  const double dt = last_result_ ? secondsBetween(last_result_->sample.stamp, stamp) : 0.0;
  auto frame =
      std::make_shared<Frame>(makeFrame(stamp, grey, camera_, extractor_, extractor_params_, *workers_));
  result.sample.stamp = stamp;
  result.sample.pose = last_result_ ? last_result_->sample.pose : Eigen::Isometry3d::Identity();

  if (state_ == OrbState::kInitialising) {
    frame_ = std::move(frame);
    startMap(result, dt);
  } else {
    std::vector<Observation> last = frame_->observations;
    frame_ = std::move(frame);
    frame_->observations = std::move(last);
    trackMap(result, dt);
  }
  result.state = state_;
  result.keyframes = map_ ? static_cast<int>(map_->keyframes().size()) : 0;
  result.landmarks = map_ ? static_cast<int>(map_->landmarks().size()) : 0;
  last_result_ = result;
  return result;
}

void OrbOdometry::startMap(OrbResult& result, double dt) {
  auto initial = initialiser_.add(frame_);
  if (!initial) return;
  const double elapsed = secondsBetween(initial->first->stamp, initial->second->stamp);
  map_ = std::move(initial->map);
  map_->rescale(scaleOfNewMap(elapsed), Eigen::Vector3d::Zero());
  result.restarted = restarts_ > 0;
  state_ = OrbState::kTracking;
  result.keyframe = true;
  result.tracked_points = keyframe_points_ = static_cast<int>(frame_->observations.size());
  setMotion(result, RigidTransform{}, dt, Matrix6::Zero());
  velocity_ = logTransform(frame_->T_camera_world) / elapsed;
  rememberPose();
  initialiser_.reset();
}

void OrbOdometry::trackMap(OrbResult& result, double dt) {
  const std::vector<Observation> last = std::move(frame_->observations);
  frame_->observations.clear();
  const RigidTransform predicted = expTransform(velocity_ * dt) * lastPose();
  TrackingOutcome outcome = trackFrame(camera_, *map_, last, predicted, *frame_, tracking_params_, *workers_);
  if (!outcome.tracked) {
    outcome =
        relocalise(camera_, *map_, *frame_, params_.relocalisation_inliers, tracking_params_, *workers_);
  }
  if (!outcome.tracked) {
    frame_->observations = last;
    trackingLost(result, predicted, dt);
    return;
  }
  const bool found_back = state_ != OrbState::kTracking;
  state_ = OrbState::kTracking;
  lost_for_ = 0.0;
  result.tracked_points = outcome.estimate.inliers;
  last_covariance_ = outcome.estimate.covariance;
  const bool still = standsStill();
  if (still) {
    frame_->T_camera_world = lastPose();
  } else {
    if (wantsKeyframe()) {
      takeKeyframe();
      result.keyframe = true;
    }
    still_reference_ = frame_->observations;
  }
  setMotion(result, lastPose(), dt, outcome.estimate.covariance);
  // A jump back into the map is no velocity to go on with.
  if (still) {
    result.twist.setZero();  // exactly: not the rounding of a pose and its inverse
    result.sample.speed = result.sample.yaw_rate = 0.0;
    velocity_.setZero();
  } else if (!found_back) {
    velocity_ = logTransform(frame_->T_camera_world * lastPose().inverse()) / dt;
  }
  rememberPose();
}

void OrbOdometry::trackingLost(OrbResult& result, const RigidTransform& predicted, double dt) {
  lost_for_ += dt;
  if (lost_for_ > params_.coast_time + params_.relocalisation_time) {
    beginFreshStart();
    return;
  }
  const bool coasting = lost_for_ <= params_.coast_time;
  state_ = coasting ? OrbState::kLost : OrbState::kRelocalising;
  frame_->T_camera_world = coasting ? predicted : lastPose();
  const double growth = std::pow(1.0 + kCoastingGrowth * lost_for_, 2);
  setMotion(result, lastPose(), dt, growth * last_covariance_);
  rememberPose();
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
  const auto middle = moved.begin() + static_cast<std::ptrdiff_t>(moved.size() / 2);
  std::nth_element(moved.begin(), middle, moved.end());
  return *middle < kStillPixels;
}

void OrbOdometry::beginFreshStart() {
  ++restarts_;
  carried_speed_ = velocity_.head<3>().norm();
  T_odom_world_ = T_odom_world_ * lastPose().inverse();
  map_.reset();
  velocity_.setZero();
  lost_for_ = 0.0;
  still_reference_.clear();
  state_ = OrbState::kInitialising;
  frame_->observations.clear();
  initialiser_.add(frame_);
}

double OrbOdometry::scaleOfNewMap(double elapsed) {
  if (params_.ground_plane) {
    if (const auto factor = scale_keeper_.scaleOfNewMap(camera_, *map_)) return *factor;
  }
  const double speed = carried_speed_ ? *carried_speed_ : params_.nominal_speed;
  if (speed > 0.0) return speed * elapsed / frame_->T_camera_world.translation.norm();
  return params_.camera_height > 0.0 ? kDepthInHeights * params_.camera_height : 1.0;
}

void OrbOdometry::rescale(double factor) {
  map_->rescale(factor, frame_->centre());
  T_reference_.translation *= factor;
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
  keyframe_points_ = static_cast<int>(frame_->observations.size());
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

void OrbOdometry::setMotion(OrbResult& result, const RigidTransform& previous, double dt,
                            const Matrix6& covariance) {
  const RigidTransform step = previous * frame_->T_camera_world.inverse();  // this camera in the one before
  const Vector6 twist = logTransform(step) / dt;
  result.twist.head<3>() = base_from_camera_ * twist.head<3>();
  result.twist.tail<3>() = base_from_camera_ * twist.tail<3>();
  result.sample.speed = result.twist(0);
  result.sample.yaw_rate = result.twist(5);
  result.sample.pose = basePose(frame_->T_camera_world).isometry();
  Matrix6 rotation = Matrix6::Zero();
  rotation.topLeftCorner<3, 3>() = base_from_camera_.toRotationMatrix();
  rotation.bottomRightCorner<3, 3>() = rotation.topLeftCorner<3, 3>();
  result.covariance = rotation * covariance * rotation.transpose() / (dt * dt);
}

void OrbOdometry::rememberPose() {
  const Keyframe& newest = map_->keyframes().back();
  reference_ = newest.id;
  T_reference_ = frame_->T_camera_world * newest.frame->T_camera_world.inverse();
}

RigidTransform OrbOdometry::lastPose() const {
  return T_reference_ * map_->keyframe(reference_)->frame->T_camera_world;
}

RigidTransform OrbOdometry::basePose(const RigidTransform& T_camera_world) const {
  const RigidTransform C{base_from_camera_, Eigen::Vector3d::Zero()};
  return C * T_odom_world_ * T_camera_world.inverse() * C.inverse();
}

std::vector<Eigen::Vector3d> OrbOdometry::landmarkPositions() const {
  std::vector<Eigen::Vector3d> positions;
  if (!map_) return positions;
  for (const Landmark& landmark : map_->landmarks()) {
    positions.push_back(base_from_camera_ * (T_odom_world_ * landmark.position));
  }
  return positions;
}

}  // namespace ratslam
