/// Monocular visual odometry on ORB features.
///
/// Steps for each image:
///  1. Extract features and predict the pose from the last velocity.
///  2. Track the local map (frame_tracker.h).
///  3. If the camera has moved enough, take a keyframe, triangulate new landmarks and adjust the newest window.
///  4. Correct the scale by the road plane (ground_plane.h) and the lens coefficients (lens_refinement.h).
/// The odometry closes no loops: the experience map does that.
///
/// States: initialising -> tracking; tracking -> lost (for coast_time) -> relocalising -> tracking. While tracking
/// is lost, each frame is searched for in the old map, and a new map is started beside it. If both coast_time and
/// relocalisation_time have passed, the new map takes over and continues pose and scale.
///
/// An unmeasured camera is not taken to stand still. Samples of frames that were not tracked (lost, blank, frozen,
/// before the first map) are predicted (motion_bridge.h). They are marked as bridged and have a covariance to
/// match. The first tracked frame brings a correction with the motion over the whole stretch.
///
/// Each image gives one result, which depends only on the images so far. The pose includes the corrections and so
/// jumps at them. The twist never jumps.
///
/// Frames: camera_x ... camera_yaw_deg state where the camera is in base_link (x forward, y left, z up). By default
/// base_link is at the camera's centre and level with it. The odometry frame is base_link at the first image.
/// Poses, twists and covariances are those of base_link.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "ratslam/camera/camera_model.h"
#include "ratslam/camera/image_frame.h"
#include "ratslam/common/worker_pool.h"
#include "ratslam/odometry/odometry.h"
#include "ratslam/odometry/orb/frame_tracker.h"
#include "ratslam/odometry/orb/lens_refinement.h"
#include "ratslam/odometry/orb/map_initialiser.h"
#include "ratslam/odometry/orb/motion_bridge.h"
#include "ratslam/odometry/orb/motion_history.h"
#include "ratslam/odometry/orb/orb_params.h"
#include "ratslam/odometry/orb/scale_keeper.h"
#include "ratslam/vision/feature_extractor.h"
#include "ratslam/vision/local_map.h"

namespace ratslam {

enum class OrbState { kInitialising, kTracking, kLost, kRelocalising };

struct OrbResult {
  OdometrySample sample;                 ///< with pose; the twist is that since the frame before
  Vector6 twist = Vector6::Zero();       ///< base_link: linear [m/s], angular [rad/s]
  Matrix6 covariance = Matrix6::Zero();  ///< of the twist, in its order and units
  OrbState state = OrbState::kInitialising;
  int tracked_points = 0;  ///< landmarks from which the pose was computed
  int keyframes = 0;       ///< in the local map
  int landmarks = 0;       ///< in the local map
  bool keyframe = false;   ///< this frame became one
  bool restarted = false;  ///< a new map began with this frame (not the first one)
  bool ignored = false;    ///< the stamp was not later than the last one, so the image was not used

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("sample", sample);
    fields("twist", twist);
    fields("covariance", covariance);
    fields("state", state);
    fields("tracked_points", tracked_points);
    fields("keyframes", keyframes);
    fields("landmarks", landmarks);
    fields("keyframe", keyframe);
    fields("restarted", restarted);
    fields("ignored", ignored);
  }
};

class OrbOdometry {
 public:
  /// @throws std::invalid_argument for an invalid camera or invalid parameters.
  OrbOdometry(const CameraModel& camera, const OrbOdometryParams& params);

  /// Processes the next image. An image whose stamp is not later than the last one is ignored and counted; the
  /// result is then the last one with zero motion.
  /// @param image 8-bit, one channel (grey) or three (BGR).
  /// @param quality frozen and blank images are not tracked.
  /// @throws std::invalid_argument for another type or a size that is not the camera's. Nothing has changed then.
  OrbResult track(Stamp stamp, const cv::Mat& image, ImageQuality quality = ImageQuality::kUsable);

  /// Begins where another odometry has ended, so that the pose goes on. To be called before the first image.
  void continueAt(const OrbOdometry& before) { T_odom_camera_ = before.T_odom_camera_; }

  std::int64_t ignoredFrames() const { return ignored_frames_; }
  std::int64_t restarts() const { return restarts_; }
  /// The last frame with its features and observations; null before the first.
  const Frame* frame() const { return frame_.get(); }
  /// The local map; null if there is none.
  const LocalMap* map() const { return map_ ? &*map_ : nullptr; }
  /// State of the road plane and the unit of length.
  const ScaleKeeper& scale() const { return scale_keeper_; }
  /// The camera with its present, possibly refined, coefficients.
  const CameraModel& camera() const { return camera_; }
  /// Landmarks of the local map in the odometry frame [m], for display.
  std::vector<Eigen::Vector3d> landmarkPositions() const;

  /// Saves everything that the results of later frames depend on.
  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit camera and parameters
  void load(const State& state);

 private:
  cv::Mat checkedGrey(const cv::Mat& image) const;
  /// A tracked sample, relative to a keyframe.
  struct Measured {
    Stamp stamp = 0;
    KeyframeId reference = 0;
    RigidTransform T_reference;

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("stamp", stamp);
      fields("reference", reference);
      fields("T_reference", T_reference);
    }
  };
  /// A new map that is still too young to tell how it is placed relative to the path before it.
  struct Settling {
    MotionHistory before;
    std::vector<Measured> way;  // samples since it took over

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("before", before);
      fields("way", way);
    }
  };
  /// The fields of the state that are no frames and hold none.
  template <class Fields>
  void stateFields(Fields&& fields);

  bool startMap(OrbResult& result, const MotionBridge::Step& step);
  bool trackMap(OrbResult& result, double dt);
  bool mayStartAnew(Stamp stamp) const;
  void adoptMap(InitialMap initial, OrbResult& result);
  double scaleOfNewMap(double elapsed);
  void bridge(OrbResult& result, double dt, const std::shared_ptr<Frame>& seen);
  void closeOnOldMap(OrbResult& result, double dt, const Matrix6& covariance);
  Matrix6 covarianceOfNewMap(const Eigen::Vector3d& way) const;
  void settleWhenReady(OrbResult& result);
  void settle(OrbResult& result);
  void setCorrection(OrbResult& result, Stamp to, const UncertainMotion& whole,
                     const std::vector<StampedPoseOfCamera>& way);
  bool wantsKeyframe() const;
  bool standsStill() const;
  void takeKeyframe();
  void rescale(double factor);
  void refineLens();
  void setMotion(OrbResult& result, const RigidTransform& step, double dt, const Matrix6& covariance) const;
  /// Covariance of a motion by the error of the unit of length alone.
  Matrix6 covarianceOfUnit(const Eigen::Vector3d& way) const;
  /// Covariance of a motion. @param covariance of the pose at its end.
  Matrix6 covarianceOfMotion(const RigidTransform& motion, const Matrix6& covariance) const;
  void rememberPose();
  RigidTransform lastPose() const;
  Eigen::Isometry3d inBase(const RigidTransform& motion_of_camera) const;
  Matrix6 inBase(const Matrix6& covariance) const;

  CameraModel camera_;
  OrbOdometryParams params_;
  std::unique_ptr<WorkerPool> workers_;
  ExtractorParams extractor_params_;
  FeatureExtractor extractor_;
  TrackingParams tracking_params_;
  MapInitialiser initialiser_;
  Eigen::Quaterniond base_from_camera_;
  Eigen::Vector3d camera_in_base_;  // [m]
  ScaleKeeper scale_keeper_;
  LensRefinement lens_refinement_;

  MotionHistory history_;

  OrbState state_ = OrbState::kInitialising;
  std::optional<LocalMap> map_;
  std::shared_ptr<Frame> frame_;  // last usable frame
  std::optional<OrbResult> last_result_;
  std::uint32_t epoch_ = 0;
  std::optional<MotionBridge> bridge_;  // during an unmeasured stretch
  std::optional<Settling> settling_;    // while a new map is young; the bridge is kept meanwhile
  std::shared_ptr<Frame> measured_frame_;
  RigidTransform T_odom_camera_;  // at the last sample
  RigidTransform T_odom_world_;   // world frame of the present map in the world frame of the first map
  RigidTransform T_reference_;    // last tracked frame relative to its reference keyframe
  KeyframeId reference_ = 0;
  Vector6 velocity_ = Vector6::Zero();          // left increment of the camera's pose per second
  Matrix6 last_covariance_ = Matrix6::Zero();   // of the last tracked pose
  std::vector<Observation> last_observations_;  // of the last tracked frame
  std::vector<Observation> still_reference_;    // of the last frame at which the camera had moved
  std::int64_t ignored_frames_ = 0;
  std::int64_t restarts_ = 0;
};

}  // namespace ratslam
