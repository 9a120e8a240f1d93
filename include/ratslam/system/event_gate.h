/// A queue of stamped events. An event passes once the odometry has reached its stamp.
///
/// Which events pass, in which order and with which motion depends on stamps and values, not on arrival order.
///
/// Time may go back by more than time_reset in both streams (a looped bag): then a new time begins. Events of the
/// new time wait until the odometry has gone back as well, and samples of the new time wait for the events. So no
/// motion is measured across the jump. A second source with earlier stamps (two publishers of one topic) is not
/// mistaken for a jump.
#pragma once

#include <deque>
#include <optional>

#include "ratslam/odometry/odometry_timeline.h"

namespace ratslam {

/// Result of EventGate::addEvent.
enum class EventVerdict { kAccepted, kLate, kTimeWentBack };

/// Which of the waiting events pass: those that the odometry has reached, or all of them with the motion known so
/// far (for a live odometry that is silent).
enum class Passing { kReached, kAll };

/// @tparam Event has a member `stamp`
template <class Event>
class EventGate {
 public:
  explicit EventGate(bool use_pose, const OdometryStreamParams& params = {})
      : params_(params), odometry_(use_pose, params) {}

  /// Adds a sample. kTimeWentBack: the sample opens a new time, which begins once the events have gone back, too.
  SampleVerdict addOdometry(const OdometrySample& sample) {
    // The new time may run past the end of the old one before the events have gone back.
    if (!earlier_.empty() && sample.stamp > earlier_.back().stamp &&
        secondsBetween(earlier_.back().stamp, sample.stamp) < params_.time_reset) {
      keepForTheNewTime(sample);
      return SampleVerdict::kAccepted;
    }
    const SampleVerdict verdict = odometry_.push(sample);
    if (verdict == SampleVerdict::kAccepted)
      earlier_.clear();  // the old time continues, so these were another source's
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

  /// Adds an event. kLate: it is left out. kTimeWentBack: it opens a new time.
  EventVerdict addEvent(const Event& event) {
    const bool back = last_event_ && event.stamp < *last_event_;
    if (back && !opensNewTime(event.stamp)) return EventVerdict::kLate;
    last_event_ = event.stamp;
    later_.push_back(event);
    takeLater();
    return back ? EventVerdict::kTimeWentBack : EventVerdict::kAccepted;
  }

  /// Hands out events, oldest first. During the call of `take`, motionUntil gives the motion up to the event.
  /// @param take  takes an event and returns true; false leaves the event in the queue and ends the call. If it
  /// throws, the event is removed.
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
  /// Whether the events have gone back in time and the odometry has not yet.
  bool waitsForOdometryToGoBack() const { return held_until_.has_value(); }
  std::optional<Stamp> lastEvent() const { return last_event_; }
  /// A stamp that separates the events: those that have passed are not later, all others are later.
  Stamp latestPassed() const { return events_.empty() ? last_event_.value_or(0) : events_.front().stamp - 1; }

  /// Motion from the last call to `stamp`, as far as it is known. Empty while waitsForOdometryToGoBack().
  std::vector<TimedStep> motionUntil(Stamp stamp) {
    if (held_until_ && stamp <= *held_until_) return {};
    held_until_.reset();
    return odometry_.advanceTo(stamp);
  }
  const OdometryTimeline& odometry() const { return odometry_; }
  std::optional<Stamp> clockStart() const { return odometry_.clockStart(); }
  /// For common/state.h.
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

  /// Number of times that the odometry's time has begun anew.
  std::uint64_t beginnings() const { return beginnings_; }

 private:
  static constexpr std::size_t kMostEarlier = 10000;

  bool nextIsReached() const {
    const Stamp next = events_.front().stamp;
    // If the events pass the last stamp of the odometry, it will not go back any more. The waiting events then pass
    // without motion.
    if (held_until_ && next <= *held_until_) return events_.back().stamp > *held_until_;
    return odometry_.reached(next);
  }

  void pop() {
    events_.pop_front();
    takeLater();
  }

  /// Moves events to the queue, up to one that goes back in time while earlier ones have not passed yet.
  void takeLater() {
    while (!later_.empty()) {
      const Event next = later_.front();
      const bool back = newest_taken_ && next.stamp < *newest_taken_;
      // If the odometry's old time is over as well, it will never reach the remaining events.
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

  /// @param samples  may be earlier_
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
  std::deque<Event> later_;  ///< events of a new time, while events of the old time wait for the odometry
  std::optional<Stamp> newest_taken_;
  std::optional<Stamp> last_event_;
  /// The odometry's last stamp, if the events went back in time first.
  std::optional<Stamp> held_until_;
  /// Samples of an earlier time, until the events go back, too.
  std::deque<OdometrySample> earlier_;
  std::uint64_t beginnings_ = 0;
};

}  // namespace ratslam
