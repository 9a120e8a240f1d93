/// Monocular visual odometry on ORB features: the self-motion sense of the system.
///
/// Steps for each image: extract features; predict the pose from the last velocity; track the local map
/// (frame_tracker.h); take a keyframe if the camera has moved; triangulate new landmarks; adjust the newest
/// window; correct the scale by the road plane (ground_plane.h) and the calibration of the lens
/// (lens_refinement.h). No loop is ever closed here: RatSLAM does that.
///
/// States: initialising -> tracking; tracking -> lost (for coast_time) -> relocalising -> tracking. While lost,
/// each frame is looked for in the old map, and a fresh map is started beside it, which takes over once
/// relocalisation_time has passed, too; it carries pose and scale on.
///
/// Nothing is ever said to stand still because it was not measured: samples of frames that were not tracked
/// (lost, blind, frozen, before the first map) are predictions (motion_bridge.h), marked as bridged and with a
/// covariance to match; the first tracked frame brings a correction with the motion over the whole stretch.
///
/// Every image gives a result that depends on the images so far only. The pose is continued by corrections,
/// too: it jumps there. The twist never jumps.
///
/// Frames: base_link (x forward, y left, z up) is where camera_x ... camera_yaw_deg put it, by default in the
/// camera's centre and level with it; the odometry frame is base_link at the first image. Poses, twists and
/// covariances are base_link's.
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
  OdometrySample sample;                 ///< with pose; the twist holds since the frame before
  Vector6 twist = Vector6::Zero();       ///< base_link: linear [m/s], angular [rad/s]
  Matrix6 covariance = Matrix6::Zero();  ///< of the twist, in its order and units
  OrbState state = OrbState::kInitialising;
  int tracked_points = 0;  ///< landmarks that the pose rests on
  int keyframes = 0;       ///< in the local map
  int landmarks = 0;       ///< in the local map
  bool keyframe = false;   ///< this frame became one
  bool restarted = false;  ///< a fresh map began with this frame (not the first one)
  bool ignored = false;    ///< the stamp was not later than the last: the image was not looked at

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
  /// @throws std::invalid_argument for a camera or parameters that cannot be.
  OrbOdometry(const CameraModel& camera, const OrbOdometryParams& params);

  /// The next image. A stamp that is not later than the last one's is ignored and counted, and the last
  /// result is given again with zero motion.
  /// @param image 8-bit, one channel (grey) or three (BGR).
  /// @param quality frozen and blank images are not tracked.
  /// @throws std::invalid_argument for another type or a size that is not the camera's; the state is
  /// unchanged.
  OrbResult track(Stamp stamp, const cv::Mat& image, ImageQuality quality = ImageQuality::kUsable);

  std::int64_t ignoredFrames() const { return ignored_frames_; }
  std::int64_t restarts() const { return restarts_; }
  /// The last frame with its features and observations; nothing before the first.
  const Frame* frame() const { return frame_.get(); }
  /// The local map; nothing while there is none.
  const LocalMap* map() const { return map_ ? &*map_ : nullptr; }
  /// What is known of the road plane and the unit of length.
  const ScaleKeeper& scale() const { return scale_keeper_; }
  /// The camera as it is believed to be now: its lens may have been refined.
  const CameraModel& camera() const { return camera_; }
  /// Landmarks of the local map in the odometry frame [m], for display.
  std::vector<Eigen::Vector3d> landmarkPositions() const;

  /// All that the results of later frames depend on.
  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit camera and parameters
  void load(const State& state);

 private:
  cv::Mat checkedGrey(const cv::Mat& image) const;
  /// A tracked sample, as it lies to a keyframe.
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
  /// A fresh map that is still too young to say how it lies to what was before it.
  struct Settling {
    MotionHistory before;
    std::vector<Measured> way;  // since it took over

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("before", before);
      fields("way", way);
    }
  };
  /// What is neither a frame nor holds one.
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
  /// @param covariance of the pose at the end.
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
  std::shared_ptr<Frame> frame_;  // the last that showed something
  std::optional<OrbResult> last_result_;
  std::uint32_t epoch_ = 0;
  std::optional<MotionBridge> bridge_;  // open while nothing is measured
  std::optional<Settling> settling_;    // while a fresh map is young: the bridge stays open
  std::shared_ptr<Frame> measured_frame_;
  RigidTransform T_odom_camera_;  // of the last sample
  RigidTransform T_odom_world_;   // where the present map's world lies in the first one's
  RigidTransform T_reference_;    // of the last tracked frame from the keyframe it is expressed through
  KeyframeId reference_ = 0;
  Vector6 velocity_ = Vector6::Zero();          // left increment of the camera's pose per second
  Matrix6 last_covariance_ = Matrix6::Zero();   // of the last tracked pose
  std::vector<Observation> last_observations_;  // of the last tracked frame
  std::vector<Observation> still_reference_;    // of the last frame that moved
  std::int64_t ignored_frames_ = 0;
  std::int64_t restarts_ = 0;
};

}  // namespace ratslam
