/// A stream of odometry laid out in time, so that its motion can be asked for up to any stamp.
///
/// The twist of a sample holds from the sample before it to its own stamp; the first sample only sets the
/// clock. Images come at stamps of their own, often between two samples: the motion of the sample that covers
/// an image's stamp is then divided there. What a caller gets is a function of stamps and values, never of
/// arrival order.
///
/// Not everything is driven as it was said:
///  - a silence longer than odometry_gap is a stretch nobody measured, unless the source says how well it
///    knows its motion: the poses at its two ends say where it led, else nothing does, and it is as loose as
///    the fastest motion seen so far could make it;
///  - a pose that jumps far beyond what the twist says (a source that started anew at its origin) and a change
///    of epoch are bridged by the twist, as loosely, and leave the unit of length behind;
///  - a source whose twist is zero while its pose moves is followed by its pose.
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
  double time_reset = 1.0;

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("odometry_gap", odometry_gap, Bounds{1e-3, 1e6},
          "time without odometry after which the motion counts as unmeasured [s]");
    visit("odometry_reset", time_reset, Bounds{1e-3, 1e6},
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
  std::optional<OdometryCorrection> correction;  ///< known from this stamp on
};

/// What became of a sample handed to OdometryTimeline::push.
enum class SampleVerdict { kAccepted, kImpossible, kRepeatedStamp, kLate, kTimeWentBack };

class OdometryTimeline {
 public:
  /// @param use_pose  take displacements from the samples' poses, where given, instead of from their twists
  explicit OdometryTimeline(bool use_pose, const OdometryStreamParams& params = {})
      : use_pose_(use_pose), params_(params) {}

  /// Appends a sample. A covariance that cannot be used counts as not said. Only an accepted sample changes anything: values that are impossible (possible.h), a stamp already
  /// seen and a stamp before it are reported to the caller, who counts, warns or resets.
  SampleVerdict push(const OdometrySample& sample);

  /// True once motion up to `stamp` is known.
  bool reached(Stamp stamp) const { return last_ && stamp <= last_->stamp; }

  /// Steps from where the last call ended (at first: the first sample) to `stamp`, or as far towards it as
  /// the motion is known, oldest first; empty where that is no time.
  std::vector<TimedStep> advanceTo(Stamp stamp);
  /// The same steps, which stay to be asked for again.
  std::vector<TimedStep> lookAhead(Stamp stamp) const;

  /// Start of the known time, once the first sample has set the clock.
  std::optional<Stamp> clockStart() const { return start_; }
  /// Where the last call of advanceTo ended.
  Stamp cursor() const { return cursor_; }
  std::optional<Stamp> lastStamp() const { return last_ ? std::optional<Stamp>(last_->stamp) : std::nullopt; }

  /// Stretches that nobody measured so far.
  std::uint64_t unmeasured() const { return unmeasured_; }

  /// Forgets everything; the next sample sets the clock anew.
  void reset();

  /// What it knows, for common/state.h.
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
  double fastest_ = 0.0;       ///< speed so far [m/s]
  double fastest_turn_ = 0.0;  ///< yaw rate so far [rad/s]
  std::uint64_t unmeasured_ = 0;
};

}  // namespace ratslam
