/// An unmeasured stretch: from the last tracked frame to the first frame that is tracked again.
///
/// During the stretch each sample is predicted from the motion before. Far features give its turn if the image
/// shows any (far_view.h). After the stretch its motion is known better: from the motion before and after, from
/// far features, or from the map. Then its samples are recomputed.
///
/// The frames in between form a chain. If far features connect a frame to the one before, the turn between them is
/// measured. Otherwise, for example across a gap, it is interpolated from the turn rates at both ends
/// (motion_history.h). The speed changes evenly from the one before the stretch to the one after it.
///
/// Memory and time are bounded for a stretch of any length: whenever there are too many samples or links of the
/// chain, those of the older half are joined two by two.
///
/// All poses are those of the camera in the odometry's frame.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ratslam/odometry/orb/far_view.h"
#include "ratslam/odometry/orb/motion_history.h"
#include "ratslam/vision/frame_state.h"

namespace ratslam {

/// Composition: first `a`, then `b`, with the covariance of both.
UncertainMotion compose(const UncertainMotion& a, const UncertainMotion& b);

struct StampedPoseOfCamera {
  Stamp stamp = 0;
  RigidTransform pose;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("stamp", stamp);
    fields("pose", pose);
  }
};

class MotionBridge {
 public:
  /// @param frame the last tracked frame; null if there was no map before.
  MotionBridge(Stamp from, const RigidTransform& pose, std::shared_ptr<const Frame> frame)
      : from_{from, pose}, last_frame_pose_(pose), before_(std::move(frame)) {
    last_frame_ = before_;
  }

  Stamp from() const { return from_.stamp; }
  const RigidTransform& startPose() const { return from_.pose; }
  /// Time from the start to `stamp` [s].
  double lasts(Stamp stamp) const { return secondsBetween(from_.stamp, stamp); }
  /// Predicted pose at `stamp`. Does not add a sample.
  RigidTransform posePredicted(Stamp stamp, const MotionHistory& history) const {
    return lastPose() * predict(stamp, history).motion;
  }

  /// A sample before it is added.
  struct Step {
    Stamp stamp = 0;
    UncertainMotion motion;  ///< since the last sample
    RigidTransform pose;
    std::optional<UncertainMotion> seen;  ///< motion since the last frame by far features; |translation| = 1
  };
  /// Predicts the next sample. @param frame null if the image shows nothing.
  Step look(const CameraModel& camera, Stamp stamp, const Frame* frame, const MotionHistory& history,
            WorkerPool& workers) const;
  /// Adds the sample.
  void add(const Step& step, std::shared_ptr<const Frame> frame);
  /// The turn from an earlier frame to that of a step; none unless far features connect all frames in between.
  std::optional<UncertainTurn> turnSince(Stamp earlier, const Step& step) const;
  RigidTransform lastPose() const { return way_.empty() ? from_.pose : way_.back().pose; }

  /// The motion from the start to the frame of a sample that begins a new map. @param after twist of the camera
  /// at that frame.
  UncertainMotion motionTo(const CameraModel& camera, const Frame& frame, const Vector6& after,
                           const MotionHistory& history, WorkerPool& workers) const;
  /// The frame at the start; null if there is none.
  const Frame* before() const { return before_.get(); }
  /// Those frames of the start and the samples that are usable and still kept.
  std::vector<std::shared_ptr<const Frame>> frames() const;
  /// Recomputes the samples between poses that are known by now. @param known ascending, relative to the start; the
  /// last one is the end of the stretch. @param before, after twists at both ends: between known poses the speed
  /// changes evenly.
  std::vector<StampedPoseOfCamera> layOut(const std::vector<StampedPoseOfCamera>& known,
                                          const Vector6& before, const Vector6& after) const;

  void save(State& state, FramesToSave& frames) const;
  /// @throws std::runtime_error naming what is missing
  static MotionBridge loaded(const State& state, const LoadedFrames& frames);

 private:
  struct Sample {
    Stamp stamp = 0;
    RigidTransform pose;
    std::shared_ptr<const Frame> frame;
  };
  /// Motion from one frame to the next.
  struct Link {
    Stamp begin = 0;
    Stamp end = 0;
    std::optional<UncertainMotion> seen;  // by far features; |translation| = 1

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("begin", begin);
      fields("end", end);
      fields("seen", seen);
    }
  };
  /// Consecutive links without far features.
  struct Blind {
    double begin = 0.0;  // seconds from the start
    double end = 0.0;
    Eigen::Vector3d rate_before = Eigen::Vector3d::Zero();  // [rad/s]
    Eigen::Vector3d rate_after = Eigen::Vector3d::Zero();
  };
  UncertainMotion predict(Stamp stamp, const MotionHistory& history) const;
  Stamp lastFrameStamp() const { return last_frame_ ? last_frame_->stamp : from_.stamp; }
  Blind blindAround(std::size_t link, const Vector6& before, const Vector6& after) const;
  /// The motion along a link. @param before, after twists at both ends of a stretch of `whole` seconds.
  RigidTransform along(std::size_t link, const Vector6& before, const Vector6& after, double whole) const;
  Matrix6 covarianceAlong(std::size_t link, const RigidTransform& motion, const Vector6& before,
                          const Vector6& after, bool known_before) const;
  void thinOutFrames();
  void thinOutSamples();
  static Link joined(const Link& first, const Link& second);

  StampedPoseOfCamera from_;
  std::vector<Sample> way_;
  std::vector<Link> links_;
  RigidTransform last_frame_pose_;           // of last_frame_
  std::shared_ptr<const Frame> before_;      // frame at the start
  std::shared_ptr<const Frame> last_frame_;  // last usable frame
};

}  // namespace ratslam
