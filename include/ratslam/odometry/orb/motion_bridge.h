/// A stretch over which nothing was measured: from the last tracked frame to where tracking is back.
///
/// While it lasts, each sample is predicted from the motion before, turned by what far features say where the
/// image shows any (far_view.h). Once tracking is back, the whole stretch is known better - from the motion
/// before and after, from far features of both ends, or from the map itself - and its samples are laid anew
/// along it.
///
/// All poses are those of the camera in one frame of reference, the odometry's.
#pragma once

#include <memory>
#include <vector>

#include "ratslam/odometry/orb/far_view.h"
#include "ratslam/odometry/orb/motion_history.h"

namespace ratslam {

/// a after b, with the covariance of both.
UncertainMotion compose(const UncertainMotion& a, const UncertainMotion& b);

struct StampedPoseOfCamera {
  Stamp stamp = 0;
  RigidTransform pose;
};

class MotionBridge {
 public:
  /// @param frame the last one that was tracked; none where there was no map before.
  MotionBridge(Stamp from, const RigidTransform& pose, std::shared_ptr<const Frame> frame)
      : from_{from, pose}, last_frame_pose_(pose), before_(std::move(frame)) {
    last_frame_ = before_;
  }

  Stamp from() const { return from_.stamp; }
  const RigidTransform& startPose() const { return from_.pose; }
  /// Seconds from the start to `stamp`.
  double lasts(Stamp stamp) const { return secondsBetween(from_.stamp, stamp); }
  /// Predicted motion since the last sample (or the start).
  UncertainMotion predict(Stamp stamp, const MotionHistory& history) const;
  /// Predicted pose at `stamp`, nothing added.
  RigidTransform posePredicted(Stamp stamp, const MotionHistory& history) const {
    return lastPose() * predict(stamp, history).motion;
  }
  /// Adds a sample. @param frame none where the image shows nothing. @return the motion since the last one.
  UncertainMotion add(const CameraModel& camera, Stamp stamp, std::shared_ptr<const Frame> frame,
                      const MotionHistory& history, WorkerPool& workers);
  /// Pose of the sample at `stamp`; the last one's where there is none.
  RigidTransform poseAt(Stamp stamp) const;
  RigidTransform lastPose() const { return way_.empty() ? from_.pose : way_.back().pose; }

  /// The motion from the start to a frame, the first of a new map, given the twist of the camera there.
  UncertainMotion motionTo(const CameraModel& camera, const Frame& frame, const Vector6& twist_after,
                           const MotionHistory& history, WorkerPool& workers) const;
  /// The frame at the start, if there is one.
  const Frame* before() const { return before_.get(); }
  /// The frames of start and samples that showed something, as far as they are kept.
  std::vector<std::shared_ptr<const Frame>> frames() const;
  /// The samples laid anew between places that are known by now. @param known ascending, relative to the
  /// start, the last one where the stretch ends. @param before, after twists at both ends: what is not known
  /// is filled by a speed that changes evenly.
  std::vector<StampedPoseOfCamera> layOut(const std::vector<StampedPoseOfCamera>& known,
                                          const Vector6& before, const Vector6& after) const;

 private:
  struct Sample {
    Stamp stamp = 0;
    RigidTransform pose;
    std::shared_ptr<const Frame> frame;
  };
  void thinOutFrames();

  StampedPoseOfCamera from_;
  std::vector<Sample> way_;
  RigidTransform last_frame_pose_;           // of last_frame_
  std::shared_ptr<const Frame> before_;      // at the start
  std::shared_ptr<const Frame> last_frame_;  // the last that showed something
};

}  // namespace ratslam
