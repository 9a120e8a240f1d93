/// A stream of odometry on a time line. It gives the motion up to any stamp.
///
/// The twist of a sample holds from the stamp of the sample before to its own. The first sample only sets the
/// clock. The stamp of an image often lies between two samples: then the motion of the later sample is divided at
/// that stamp. The result is a function of stamps and values, never of arrival order.
///
/// The motion of a sample is not always used as it is:
///  - A silence longer than odometry_gap is an unmeasured stretch, unless the source states the covariance of the
///    twist and of its unit. Its motion follows from the poses at both ends, and without poses is unknown. Its
///    covariance allows for the fastest motion so far.
///  - A pose that jumps far beyond the twist (the source started anew at its origin) is not used, nor is the pose
///    across a change of epoch. The motion is that of the twist, with a covariance as large, and the unit of
///    length begins anew.
///  - If the twist is zero while the pose moves, the motion is that of the pose.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "ratslam/common/params.h"
#include "ratslam/odometry/odometry.h"

namespace ratslam {

struct OdometryStreamParams {
  double odometry_gap = 2.0;
  double odometry_reset = 1.0;

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("odometry_gap", odometry_gap, Bounds{1e-3, 1e6},
          "time without odometry after which the motion counts as unmeasured [s]");
    visit("odometry_reset", odometry_reset, Bounds{1e-3, 1e6},
          "a stamp of odometry or a view that steps back by less is late and left out; by more, time begins "
          "anew [s]");
  }
  /// @throws std::invalid_argument naming key, value and bound
  void validate() const { checkBounds(*this); }
};

/// A step and the stamp at which it ends.
struct TimedStep {
  Stamp end = 0;
  OdometryStep step;
  std::optional<OdometryCorrection> correction;  ///< that became known at this stamp
};

/// Result of OdometryTimeline::push; kHeld and kAhead are of EventGate::addOdometry alone.
enum class SampleVerdict { kAccepted, kImpossible, kRepeatedStamp, kLate, kTimeWentBack, kHeld, kAhead };

class OdometryTimeline {
 public:
  /// @param use_pose  take displacements from the samples' poses, if they have any, instead of their twists
  explicit OdometryTimeline(bool use_pose, const OdometryStreamParams& params = {})
      : use_pose_(use_pose), params_(params) {}

  /// Appends a sample. A covariance that cannot be used counts as unknown. Only an accepted sample changes
  /// anything. Impossible values (possible.h), a repeated stamp and an earlier stamp are reported to the caller,
  /// who counts, warns or resets.
  SampleVerdict push(const OdometrySample& sample);

  /// True once motion up to `stamp` is known.
  bool reached(Stamp stamp) const { return last_ && stamp <= last_->stamp; }

  /// Steps from the end of the last call (at first: from the first sample) to `stamp`, oldest first. They end
  /// earlier if the motion is not known up to `stamp`, and are empty if no time has passed.
  std::vector<TimedStep> advanceTo(Stamp stamp);
  /// All known steps after `from`, which does not lie before cursor(), without consuming them.
  std::vector<TimedStep> lookAhead(Stamp from) const;

  /// Stamp of the first sample; none before it.
  std::optional<Stamp> clockStart() const { return start_; }
  /// Stamp at which the last call of advanceTo ended.
  Stamp cursor() const { return cursor_; }
  std::optional<Stamp> lastStamp() const { return last_ ? std::optional<Stamp>(last_->stamp) : std::nullopt; }

  /// Number of unmeasured stretches so far, before any reset() too.
  std::uint64_t unmeasured() const { return unmeasured_; }

  /// Forgets everything else; the next sample sets the clock anew.
  void reset();

  /// For common/state.h.
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("start", start_);
    fields("cursor", cursor_);
    fields("last", last_);
    fields("pending", pending_);
    fields("fastest", fastest_);
    fields("fastest_turn", fastest_turn_);
    fields("unmeasured", unmeasured_);
  }

 private:
  struct Interval {
    Stamp begin = 0;
    Stamp end = 0;
    OdometryStep whole;
    bool from_pose = false;
    Eigen::Quaterniond tilt_before = Eigen::Quaterniond::Identity();
    std::optional<OdometryCorrection> correction;

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("begin", begin);
      fields("end", end);
      fields("whole", whole);
      fields("from_pose", from_pose);
      fields("tilt_before", tilt_before);
      fields("correction", correction);
    }
  };

  Interval intervalTo(const OdometrySample& sample);
  bool contradicts(const OdometryStep& by_pose, const OdometryStep& by_twist, bool pose_only) const;
  StepCovariance looseCovariance(double dt) const;
  TimedStep stepOf(const Interval& interval, Stamp from, Stamp to) const;

  bool use_pose_;
  OdometryStreamParams params_;
  std::optional<Stamp> start_;
  Stamp cursor_ = 0;
  std::optional<OdometrySample> last_;
  std::deque<Interval> pending_;
  double fastest_ = 0.0;       ///< highest speed so far [m/s]
  double fastest_turn_ = 0.0;  ///< highest yaw rate so far [rad/s]
  std::uint64_t unmeasured_ = 0;
};

}  // namespace ratslam
