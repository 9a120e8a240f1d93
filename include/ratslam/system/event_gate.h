/// Lets stamped events pass once the odometry has reached their stamps.
///
/// What passes, in which order and with which motion follows from stamps and values, not from arrival order.
///
/// Time may go back by more than time_reset in both streams (a looped bag): that is a new beginning. Events of
/// the new time wait until the odometry has gone back as well, and samples of the new time until the events
/// have: no motion is ever measured across the jump, and a second source whose stamps lie further back (two
/// publishers of one topic) is never taken for one.
#pragma once

#include <deque>
#include <optional>

#include "ratslam/odometry/odometry_timeline.h"

namespace ratslam {

/// What became of an event.
enum class EventVerdict { kAccepted, kLate, kTimeWentBack };

/// Which of the waiting events pass: those that the odometry has reached, or all of them, with the motion known so
/// far (a live odometry has fallen silent).
enum class Passing { kReached, kAll };

/// @tparam Event has a member `stamp`
template <class Event>
class EventGate {
 public:
  explicit EventGate(bool use_pose, const OdometryStreamParams& params = {})
      : params_(params), odometry_(use_pose, params) {}

  /// kTimeWentBack: the sample opens a new time, which begins once the events have gone back, too.
  SampleVerdict addOdometry(const OdometrySample& sample) {
    // The new time may run past the end of the old one before the events have gone back.
    if (!earlier_.empty() && sample.stamp > earlier_.back().stamp &&
        secondsBetween(earlier_.back().stamp, sample.stamp) < params_.time_reset) {
      keepForTheNewTime(sample);
      return SampleVerdict::kAccepted;
    }
    const SampleVerdict verdict = odometry_.push(sample);
    if (verdict == SampleVerdict::kAccepted) earlier_.clear();  // of another source: this one goes on
    if (verdict != SampleVerdict::kTimeWentBack) return verdict;
    if (held_until_) {
      startAnew({sample});
      return verdict;
    }
    if (!earlier_.empty() && sample.stamp <= earlier_.back().stamp) {
      if (secondsBetween(sample.stamp, earlier_.back().stamp) < params_.time_reset)
        return SampleVerdict::kLate;
      earlier_.clear();
    }
    const bool first = earlier_.empty();
    keepForTheNewTime(sample);
    takeLater();
    return first ? SampleVerdict::kTimeWentBack : SampleVerdict::kAccepted;
  }

  /// Whether an event of this stamp would open a new time.
  bool opensNewTime(Stamp stamp) const {
    return last_event_ && stamp < *last_event_ && secondsBetween(stamp, *last_event_) >= params_.time_reset;
  }

  /// kLate: the event is left out. kTimeWentBack: it opens a new time.
  EventVerdict addEvent(const Event& event) {
    const bool back = last_event_ && event.stamp < *last_event_;
    if (back && !opensNewTime(event.stamp)) return EventVerdict::kLate;
    last_event_ = event.stamp;
    later_.push_back(event);
    takeLater();
    return back ? EventVerdict::kTimeWentBack : EventVerdict::kAccepted;
  }

  /// Hands out events, oldest first. While an event is taken, motionUntil gives its motion.
  /// @param take  takes an event and returns true, or leaves it by false, which ends the call; an event at which it
  /// throws is gone all the same
  template <class Take>
  void pass(Passing which, Take&& take) {
    while (!events_.empty() && (which == Passing::kAll || nextIsReached())) {
      const Event event = events_.front();
      try {
        if (!take(event)) return;
      } catch (...) {
        pop();
        throw;
      }
      pop();
    }
  }
  /// The next event, whether or not the odometry has reached it.
  const Event* waiting() const { return events_.empty() ? nullptr : &events_.front(); }
  std::size_t size() const { return events_.size() + later_.size(); }
  /// Whether the events have gone back in time and the odometry has not, so far.
  bool waitsForOdometryToGoBack() const { return held_until_.has_value(); }
  std::optional<Stamp> lastEvent() const { return last_event_; }
  /// A stamp that the events which have passed do not exceed, but all others do.
  Stamp latestPassed() const { return events_.empty() ? last_event_.value_or(0) : events_.front().stamp - 1; }

  /// Motion since the last call up to `stamp`, as far as it is known; none while the events wait for the
  /// odometry to go back in time with them.
  std::vector<TimedStep> motionUntil(Stamp stamp) {
    if (held_until_ && stamp <= *held_until_) return {};
    held_until_.reset();
    return odometry_.advanceTo(stamp);
  }
  const OdometryTimeline& odometry() const { return odometry_; }
  std::optional<Stamp> clockStart() const { return odometry_.clockStart(); }
  /// What it knows, for common/state.h.
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("odometry", odometry_);
    fields("events", events_);
    fields("later", later_);
    fields("newest_taken", newest_taken_);
    fields("last_event", last_event_);
    fields("held_until", held_until_);
    fields("earlier", earlier_);
    fields("beginnings", beginnings_);
  }

  /// How many times the odometry's time has begun anew.
  std::uint64_t beginnings() const { return beginnings_; }

 private:
  static constexpr std::size_t kMostEarlier = 10000;

  bool nextIsReached() const {
    const Stamp next = events_.front().stamp;
    // Once the events run past where the odometry was, it is clear that it will not go back: what waits has no motion of
    // its own.
    if (held_until_ && next <= *held_until_) return events_.back().stamp > *held_until_;
    return odometry_.reached(next);
  }

  void pop() {
    events_.pop_front();
    takeLater();
  }

  /// Takes events in, up to one that goes back in time while those before it have yet to pass.
  void takeLater() {
    while (!later_.empty()) {
      const Event next = later_.front();
      const bool back = newest_taken_ && next.stamp < *newest_taken_;
      // Once the odometry's old time is over as well, what it has not reached will never be.
      const bool will_pass = !events_.empty() && (earlier_.empty() || nextIsReached());
      if (back && will_pass) return;
      later_.pop_front();
      newest_taken_ = next.stamp;
      if (back) events_.clear();
      events_.push_back(next);
      if (!back) continue;
      if (!earlier_.empty()) {
        startAnew(earlier_);
      } else if (odometry_.cursor() > next.stamp) {
        held_until_ = odometry_.lastStamp();
      }
    }
  }

  void keepForTheNewTime(const OdometrySample& sample) {
    earlier_.push_back(sample);
    if (earlier_.size() > kMostEarlier) earlier_.pop_front();
  }

  /// @param samples  may be those that are kept for the new time
  void startAnew(const std::deque<OdometrySample>& samples) {
    odometry_.reset();
    for (const OdometrySample& sample : samples) odometry_.push(sample);
    earlier_.clear();
    held_until_.reset();
    ++beginnings_;
  }

  OdometryStreamParams params_;
  OdometryTimeline odometry_;
  std::deque<Event> events_;
  std::deque<Event> later_;  ///< of a new time, while events of the old one wait for the odometry
  std::optional<Stamp> newest_taken_;
  std::optional<Stamp> last_event_;
  /// The odometry's last stamp when the events went back in time before it.
  std::optional<Stamp> held_until_;
  /// Samples of a time further back, until the events go back, too.
  std::deque<OdometrySample> earlier_;
  std::uint64_t beginnings_ = 0;
};

}  // namespace ratslam
