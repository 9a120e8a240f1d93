/// Lets stamped events pass once the odometry has reached their stamps.
///
/// What passes, in which order and with which motion follows from stamps and values, not from arrival order.
/// When time goes back in one stream (a looped bag) the events of the old time are forgotten, and those of
/// the new time wait until the odometry has gone back as well: no motion is ever measured across the jump.
#pragma once

#include <deque>
#include <optional>

#include "ratslam/odometry/odometry_timeline.h"

namespace ratslam {

/// @tparam Event has a member `stamp`
template <class Event>
class EventGate {
 public:
  explicit EventGate(bool use_pose) : odometry_(use_pose) {}

  /// kTimeWentBack has already reset the stream: the sample that told so sets the clock anew.
  SampleVerdict addOdometry(const OdometrySample& sample) {
    const SampleVerdict verdict = odometry_.push(sample);
    if (verdict == SampleVerdict::kTimeWentBack) {
      odometry_.reset();
      odometry_.push(sample);
      if (!held_until_) events_.clear();
      held_until_.reset();
    }
    return verdict;
  }

  /// @return false where the event's stamp lies before the one before it: the old events are forgotten
  bool addEvent(const Event& event) {
    const bool forward = !last_event_ || event.stamp >= *last_event_;
    if (!forward) {
      events_.clear();
      if (odometry_.cursor() > event.stamp) held_until_ = odometry_.lastStamp();
    }
    last_event_ = event.stamp;
    events_.push_back(event);
    return forward;
  }

  /// The next event, where the odometry has reached it.
  const Event* ready() const {
    if (events_.empty()) return nullptr;
    const Event& next = events_.front();
    if (held_until_ && next.stamp <= *held_until_) return nullptr;
    return odometry_.reached(next.stamp) ? &next : nullptr;
  }
  /// The next event, whether or not the odometry has reached it.
  const Event* waiting() const { return events_.empty() ? nullptr : &events_.front(); }
  void pop() { events_.pop_front(); }
  std::size_t size() const { return events_.size(); }

  /// Motion since the last call up to `stamp`, as far as it is known; none while the events wait for the
  /// odometry to go back in time with them.
  std::vector<TimedStep> motionUntil(Stamp stamp) {
    if (held_until_ && stamp <= *held_until_) return {};
    return odometry_.advanceTo(stamp);
  }
  std::optional<Stamp> clockStart() const { return odometry_.clockStart(); }

  /// What it knows, for common/state.h.
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("odometry", odometry_);
    fields("events", events_);
    fields("last_event", last_event_);
    fields("held_until", held_until_);
  }

 private:
  OdometryTimeline odometry_;
  std::deque<Event> events_;
  std::optional<Stamp> last_event_;
  std::optional<Stamp>
      held_until_;  ///< the odometry's last stamp when the events went back in time before it
};

}  // namespace ratslam
