/// A stretch over which nothing was measured: from the last tracked frame to where tracking is back.
///
/// While it lasts, each sample is predicted from the motion before, turned by what far features say where the
/// image shows any (far_view.h). Once tracking is back, the whole stretch is known better - from the motion
/// before and after, from far features, or from the map itself - and its samples are laid anew along it.
///
/// The frames seen in between are a chain. Where far features connect a frame to the one before, the turn from
/// one to the other is measured; where nothing does, as across a gap, the turn rates at both ends fill it
/// (motion_history.h). The speed changes evenly from the one before the stretch to the one after it.
///
/// However long it lasts, it takes a bounded amount of memory and time: the older half of the samples and of the chain
/// is joined two by two whenever there are too many of them.
///
/// All poses are those of the camera in one frame of reference, the odometry's.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ratslam/odometry/orb/far_view.h"
#include "ratslam/odometry/orb/motion_history.h"
#include "ratslam/vision/frame_state.h"

namespace ratslam {

/// a after b, with the covariance of both.
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
  /// @param frame the last one that was tracked; none where there was no map before.
  MotionBridge(Stamp from, const RigidTransform& pose, std::shared_ptr<const Frame> frame)
      : from_{from, pose}, last_frame_pose_(pose), before_(std::move(frame)) {
    last_frame_ = before_;
  }

  Stamp from() const { return from_.stamp; }
  const RigidTransform& startPose() const { return from_.pose; }
  /// Seconds from the start to `stamp`.
  double lasts(Stamp stamp) const { return secondsBetween(from_.stamp, stamp); }
  /// Predicted pose at `stamp`, nothing added.
  RigidTransform posePredicted(Stamp stamp, const MotionHistory& history) const {
    return lastPose() * predict(stamp, history).motion;
  }

  /// What is known of a sample before it is added.
  struct Step {
    Stamp stamp = 0;
    UncertainMotion motion;  ///< since the last sample
    RigidTransform pose;
    std::optional<UncertainMotion> seen;  ///< since the last frame, by far features; |translation| = 1
  };
  /// @param frame none where the image shows nothing.
  Step look(const CameraModel& camera, Stamp stamp, const Frame* frame, const MotionHistory& history,
            WorkerPool& workers) const;
  /// Adds it.
  void add(const Step& step, std::shared_ptr<const Frame> frame);
  /// The turn from an earlier frame to a step's, where far features connect all frames between them.
  std::optional<UncertainTurn> turnSince(Stamp earlier, const Step& step) const;
  RigidTransform lastPose() const { return way_.empty() ? from_.pose : way_.back().pose; }

  /// The motion from the start to a frame of a sample, the first of a new map. @param after
  /// twist of the camera there.
  UncertainMotion motionTo(const CameraModel& camera, const Frame& frame, const Vector6& after,
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

  void save(State& state, FramesToSave& frames) const;
  /// @throws std::runtime_error naming what is missing
  static MotionBridge loaded(const State& state, const LoadedFrames& frames);

 private:
  struct Sample {
    Stamp stamp = 0;
    RigidTransform pose;
    std::shared_ptr<const Frame> frame;
  };
  /// From one frame to the next.
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
  /// Consecutive links that no far features connect.
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
  std::shared_ptr<const Frame> before_;      // at the start
  std::shared_ptr<const Frame> last_frame_;  // the last that showed something
};

}  // namespace ratslam
