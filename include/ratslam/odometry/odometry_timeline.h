/// A stream of odometry laid out in time, so that its motion can be asked for up to any stamp.
///
/// The twist of a sample holds from the sample before it to its own stamp; the first sample only sets the
/// clock. Images come at stamps of their own, often between two samples: the motion of the sample that covers
/// an image's stamp is then divided there. What a caller gets is a function of stamps and values, never of
/// arrival order.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "ratslam/odometry/odometry.h"

namespace ratslam {

/// A step and the stamp at which it ends.
struct TimedStep {
  Stamp end = 0;
  OdometryStep step;
};

/// What became of a sample handed to OdometryTimeline::push.
enum class SampleVerdict { kAccepted, kNotFinite, kRepeatedStamp, kTimeWentBack };

class OdometryTimeline {
 public:
  /// @param use_pose  take displacements from the samples' poses, where given, instead of from their twists
  explicit OdometryTimeline(bool use_pose) : use_pose_(use_pose) {}

  /// Appends a sample. Only an accepted sample changes anything: values that are not finite, a stamp already
  /// seen and a stamp before it are reported to the caller, who counts, warns or resets.
  SampleVerdict push(const OdometrySample& sample);

  /// True once motion up to `stamp` is known.
  bool reached(Stamp stamp) const { return last_ && stamp <= last_->stamp; }

  /// Steps from where the last call ended (at first: the first sample) to `stamp`, or as far towards it as
  /// the motion is known, oldest first; empty where that is no time.
  std::vector<TimedStep> advanceTo(Stamp stamp);

  /// Start of the known time, once the first sample has set the clock.
  std::optional<Stamp> clockStart() const { return start_; }
  /// Where the last call of advanceTo ended.
  Stamp cursor() const { return cursor_; }
  std::optional<Stamp> lastStamp() const { return last_ ? std::optional<Stamp>(last_->stamp) : std::nullopt; }

  /// Forgets everything; the next sample sets the clock anew.
  void reset();

  /// What it knows, for common/state.h.
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("start", start_);
    fields("cursor", cursor_);
    fields("last", last_);
    fields("pending", pending_);
  }

 private:
  struct Interval {
    Stamp begin = 0;
    Stamp end = 0;
    OdometryStep whole;
    bool from_pose = false;

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("begin", begin);
      fields("end", end);
      fields("whole", whole);
      fields("from_pose", from_pose);
    }
  };

  Interval intervalTo(const OdometrySample& sample) const;

  bool use_pose_;
  std::optional<Stamp> start_;
  Stamp cursor_ = 0;
  std::optional<OdometrySample> last_;
  std::deque<Interval> pending_;
};

}  // namespace ratslam
