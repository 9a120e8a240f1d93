/// A queue of stamped events. An event passes once the odometry has reached its stamp.
///
/// Which events pass, in which order and with which motion depends on stamps and values, not on arrival order.
///
/// Time may go back by more than odometry_reset in both streams (a looped bag): then a new time begins. Events of the
/// new time wait until the odometry has gone back as well, and samples of the new time wait for the events. So no
/// motion is measured across the jump. A second source with earlier stamps (two publishers of one topic) is not
/// mistaken for a jump.
///
/// A single sample with a stamp far ahead must not end the stream. So a sample that is the first, or that jumps ahead
/// by more than odometry_reset, is held. The next sample decides. If it continues from the held one, or an event
/// reaches the held stamp, the held sample is accepted. If it continues from the sample before, the held one is dropped
/// (if the held one is the first, two such samples are needed).
///
/// A single event with a stamp far ahead is dropped while it waits, if the next event and the odometry continue from
/// the event before.
#pragma once

#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "ratslam/odometry/odometry_timeline.h"
#include "ratslam/odometry/possible.h"

namespace ratslam {

/// Result of EventGate::addEvent.
enum class EventVerdict { kAccepted, kLate, kTimeWentBack };

/// Which of the waiting events pass: those that the odometry has reached, or all of them with the motion known so
/// far (for a live odometry that is silent).
enum class Passing { kReached, kAll };

/// A sample that was held, and what became of it.
struct DecidedSample {
  OdometrySample sample;
  SampleVerdict verdict = SampleVerdict::kAccepted;
  bool unmeasured = false;  ///< it ends an unmeasured stretch
  bool put_aside = false;   ///< it belongs to a time that has not begun (EventGate::isPutAside)
};

/// @tparam Event has a member `stamp`
template <class Event>
class EventGate {
 public:
  /// So many samples are put aside at most, the newest ones.
  static constexpr std::size_t kMostEarlier = 10000;

  /// @param drops_ahead  whether an event ahead of time may be dropped
  explicit EventGate(bool use_pose, const OdometryStreamParams& params = {}, bool drops_ahead = true)
      : params_(params), drops_ahead_(drops_ahead), odometry_(use_pose, params) {}

  /// Adds a sample. kTimeWentBack: the sample opens a new time, which begins once the events have gone back, too.
  /// kHeld: a later call decides, and takeDecided() then gives the sample.
  SampleVerdict addOdometry(const OdometrySample& sample) {
    decided_.clear();
    if (!whyImpossible(sample).empty()) return SampleVerdict::kImpossible;
    if (held_) {
      if (sample.stamp == held_->stamp) return SampleVerdict::kRepeatedStamp;
      if (sample.stamp > held_->stamp) {
        acceptHeld();
      } else if (!odometry_.lastStamp()) {
        if (const auto verdict = addBeforeFirst(sample)) return *verdict;
      } else if (sample.stamp > *odometry_.lastStamp()) {
        if (!refutesHeld(sample.stamp)) return SampleVerdict::kLate;
        dropHeld();
      }
    }
    if (!isDoubtful(sample.stamp)) return admit(sample);
    if (last_event_ && *last_event_ >= sample.stamp) return admit(sample);
    held_ = sample;
    return SampleVerdict::kHeld;
  }
  /// Samples that were held and have been decided since the last call of addOdometry began, the oldest first.
  std::vector<DecidedSample> takeDecided() { return std::exchange(decided_, {}); }
  /// Takes the held sample as it is: nothing more will come, or the odometry is silent.
  void acceptHeld() {
    if (held_) decideHeld([this](const OdometrySample& sample) { return admit(sample); });
  }
  /// Whether the newest sample, of this stamp, waits for the events to go back in time, too.
  bool isPutAside(Stamp stamp) const { return !earlier_.empty() && earlier_.back().stamp == stamp; }
  /// Whether samples wait so.
  bool putsAside() const { return !earlier_.empty(); }
  /// Number of samples that were not used, because they went back in time and the events did not; and the stamp of the
  /// first of them.
  std::uint64_t leftBehind() const { return left_behind_ + earlier_.size(); }
  std::optional<Stamp> firstLeftBehind() const {
    if (first_left_behind_ || earlier_.empty()) return first_left_behind_;
    return earlier_.front().stamp;
  }

  /// Whether an event of this stamp would open a new time.
  bool opensNewTime(Stamp stamp) const {
    return last_event_ && stamp < *last_event_ &&
           secondsBetween(stamp, *last_event_) >= params_.odometry_reset;
  }

  /// Announces an event of this stamp. A held sample with a stamp up to it is accepted.
  void expect(Stamp stamp) {
    if (held_ && stamp >= held_->stamp) acceptHeld();
  }

  /// Adds an event. kLate: it is left out. kTimeWentBack: it opens a new time.
  EventVerdict addEvent(const Event& event) {
    const bool back = last_event_ && event.stamp < *last_event_;
    if (back && !opensNewTime(event.stamp)) return EventVerdict::kLate;
    last_event_ = event.stamp;
    expect(event.stamp);
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
  /// Drops the events that wait. The odometry stays.
  void forgetWaiting() {
    events_.clear();
    later_.clear();
  }
  /// The next event, whether or not the odometry has reached it.
  const Event* waiting() const { return events_.empty() ? nullptr : &events_.front(); }
  std::size_t size() const { return events_.size() + later_.size(); }
  /// Whether the events have gone back in time and the odometry has not yet.
  bool waitsForOdometryToGoBack() const { return held_until_.has_value(); }
  std::optional<Stamp> lastEvent() const { return last_event_; }
  /// Stamps of the events that wait.
  std::vector<Stamp> waitingStamps() const {
    std::vector<Stamp> stamps;
    for (const auto* events : {&events_, &later_}) {
      for (const Event& event : *events) stamps.push_back(event.stamp);
    }
    return stamps;
  }
  /// Number of events that were dropped because they lay ahead of time.
  std::uint64_t aheadEvents() const { return ahead_events_; }
  /// Number of events that were dropped because both streams went back in time before the odometry reached them.
  std::uint64_t unreachedEvents() const { return unreached_events_; }
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
    fields("taken_before", taken_before_);
    fields("ahead_events", ahead_events_);
    fields("unreached_events", unreached_events_);
    fields("last_event", last_event_);
    fields("held_until", held_until_);
    fields("earlier", earlier_);
    fields("beginnings", beginnings_);
    fields("held", held_);
    fields("left_behind", left_behind_);
    fields("first_left_behind", first_left_behind_);
  }

  /// Number of times that the odometry's time has begun anew.
  std::uint64_t beginnings() const { return beginnings_; }

 private:
  SampleVerdict admit(const OdometrySample& sample) {
    // The new time may run past the end of the old one before the events have gone back.
    if (continuesEarlier(sample.stamp)) {
      keepForTheNewTime(sample);
      return SampleVerdict::kAccepted;
    }
    const SampleVerdict verdict = odometry_.push(sample);
    if (verdict == SampleVerdict::kAccepted) {
      forgetEarlier();  // the old time continues, so these were another source's
      takeLater();
    }
    if (verdict != SampleVerdict::kTimeWentBack) return verdict;
    if (held_until_) {
      startAnew({sample});
      return verdict;
    }
    return keepEarlier(sample);
  }

  /// Keeps a sample of an earlier time, until the events go back, too.
  SampleVerdict keepEarlier(const OdometrySample& sample) {
    if (!earlier_.empty() && sample.stamp <= earlier_.back().stamp) {
      if (secondsBetween(sample.stamp, earlier_.back().stamp) < params_.odometry_reset)
        return SampleVerdict::kLate;
      forgetEarlier();
    }
    const bool first = earlier_.empty();
    keepForTheNewTime(sample);
    takeLater();
    return first ? SampleVerdict::kTimeWentBack : SampleVerdict::kAccepted;
  }

  /// A sample before the first one, which is held. None if the first one is dropped, and the sample is still to be
  /// added.
  std::optional<SampleVerdict> addBeforeFirst(const OdometrySample& sample) {
    if (secondsBetween(sample.stamp, held_->stamp) < params_.odometry_reset) return SampleVerdict::kLate;
    if (earlier_.empty() || sample.stamp <= earlier_.back().stamp) return keepEarlier(sample);
    dropHeld();
    for (const OdometrySample& earlier : std::exchange(earlier_, {})) odometry_.push(earlier);
    return std::nullopt;
  }

  bool continuesEarlier(Stamp stamp) const {
    return !earlier_.empty() && stamp > earlier_.back().stamp &&
           secondsBetween(earlier_.back().stamp, stamp) < params_.odometry_reset;
  }

  /// Whether a sample of this stamp must be held until another one confirms it.
  bool isDoubtful(Stamp stamp) const {
    const std::optional<Stamp> last = odometry_.lastStamp();
    if (!last) return true;
    return stamp > *last && secondsBetween(*last, stamp) > params_.odometry_reset && !continuesEarlier(stamp);
  }

  /// Whether a sample with a stamp between the last one and the held one shows that the held stamp is wrong. If not,
  /// that sample is late.
  bool refutesHeld(Stamp stamp) const {
    const double back = secondsBetween(stamp, held_->stamp);
    return back >= params_.odometry_reset || secondsBetween(*odometry_.lastStamp(), stamp) < back;
  }

  void dropHeld() { decided_.push_back({*std::exchange(held_, std::nullopt), SampleVerdict::kAhead}); }

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
      if (back && held_ && !earlier_.empty()) endOldTime();
      if (back && newestIsAhead(next.stamp)) {
        events_.pop_back();
        ++ahead_events_;
        newest_taken_ = taken_before_;
        taken_before_.reset();
        continue;
      }
      // If the odometry's old time is over as well, it will never reach the remaining events.
      const bool will_pass = !events_.empty() && (earlier_.empty() || nextIsReached());
      if (back && will_pass) return;
      later_.pop_front();
      taken_before_ = std::exchange(newest_taken_, next.stamp);
      if (back) {
        unreached_events_ += events_.size();
        events_.clear();
      }
      events_.push_back(next);
      if (!back) continue;
      if (!earlier_.empty()) {
        startAnew(earlier_);
      } else if (odometry_.cursor() > next.stamp) {
        held_until_ = odometry_.lastStamp();
      }
    }
  }

  /// Whether the next event and the odometry show that the stamp of the newest waiting event is wrong.
  bool newestIsAhead(Stamp next) const {
    const std::optional<Stamp> last = odometry_.lastStamp();
    if (!drops_ahead_ || !last || events_.empty() || *last >= *newest_taken_) return false;
    const double back = secondsBetween(next, *newest_taken_);
    if (back < params_.odometry_reset) return false;
    if (!taken_before_) return true;
    const bool jumped = secondsBetween(*taken_before_, *newest_taken_) > params_.odometry_reset;
    const bool near_the_old_time = next > *taken_before_ && secondsBetween(*taken_before_, next) < back;
    const bool odometry_goes_on = *last > *taken_before_;
    return jumped && near_the_old_time && odometry_goes_on;
  }

  void keepForTheNewTime(const OdometrySample& sample) {
    earlier_.push_back(sample);
    if (earlier_.size() <= kMostEarlier) return;
    leaveBehind(1);
    earlier_.pop_front();
  }

  void forgetEarlier() {
    leaveBehind(earlier_.size());
    earlier_.clear();
  }

  void leaveBehind(std::size_t samples) {
    if (samples > 0) first_left_behind_ = firstLeftBehind();
    left_behind_ += samples;
  }

  /// Adds the held sample by `add`, which returns the verdict.
  template <class Add>
  void decideHeld(Add&& add) {
    const OdometrySample sample = *std::exchange(held_, std::nullopt);
    const std::uint64_t unmeasured = odometry_.unmeasured();
    const SampleVerdict verdict = add(sample);
    decided_.push_back({sample, verdict, odometry_.unmeasured() > unmeasured, isPutAside(sample.stamp)});
  }

  /// Both streams have gone back. The held sample was the last one of the old time, for which events may wait.
  void endOldTime() {
    decideHeld([this](const OdometrySample& sample) { return odometry_.push(sample); });
  }

  /// @param samples  may be earlier_
  void startAnew(const std::deque<OdometrySample>& samples) {
    odometry_.reset();
    for (const OdometrySample& sample : samples) odometry_.push(sample);
    earlier_.clear();
    held_.reset();
    held_until_.reset();
    ++beginnings_;
  }

  OdometryStreamParams params_;
  bool drops_ahead_;
  OdometryTimeline odometry_;
  std::deque<Event> events_;
  std::deque<Event> later_;  ///< events of a new time, while events of the old time wait for the odometry
  std::optional<Stamp> newest_taken_;
  std::optional<Stamp> taken_before_;  ///< stamp of the event taken before the newest one
  std::uint64_t ahead_events_ = 0;
  std::uint64_t unreached_events_ = 0;
  std::optional<Stamp> last_event_;
  /// The odometry's last stamp, if the events went back in time first.
  std::optional<Stamp> held_until_;
  /// Samples of an earlier time, until the events go back, too.
  std::deque<OdometrySample> earlier_;
  std::uint64_t beginnings_ = 0;
  std::optional<OdometrySample> held_;  ///< the newest sample, while its stamp is in doubt
  std::vector<DecidedSample> decided_;
  std::uint64_t left_behind_ = 0;
  std::optional<Stamp> first_left_behind_;
};

}  // namespace ratslam
