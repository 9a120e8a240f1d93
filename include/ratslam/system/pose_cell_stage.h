/// Pose cells with two stamped streams: odometry and view events.
///
/// A view event is processed once the odometry has reached its stamp. All motion since the view before makes one
/// attractor iteration, so that the rate of the odometry does not matter. Then the view cell injects activity, and the
/// decision is made. The result depends only on stamps and values.
#pragma once

#include <vector>

#include "ratslam/events.h"
#include "ratslam/pose_cells/pose_cells.h"
#include "ratslam/system/event_gate.h"
#include "ratslam/system/parameter_changes.h"

namespace ratslam {

/// Results of the pose cells for one view event.
struct PoseCellDecision {
  ViewEvent view;
  TopologicalAction action;  ///< with the view's stamp; kNone if nothing is to be done
  PoseCellEstimate estimate;
};

class PoseCellStage {
 public:
  explicit PoseCellStage(const PoseCellParams& params, const OdometryStreamParams& stream = {})
      : cells_(params), stream_(stream), gate_(false, stream) {}

  SampleVerdict addOdometry(const OdometrySample& sample) { return gate_.addOdometry(sample); }
  /// Samples that were held by their stamps and have been decided (event_gate.h).
  std::vector<DecidedSample> takeDecided() { return gate_.takeDecided(); }
  /// Announces an event of this stamp, which may decide on a held sample.
  void expect(Stamp stamp) { gate_.expect(stamp); }
  /// To be called after the last sample.
  void endOdometry() { gate_.acceptHeld(); }
  /// Number of samples that went back in time alone and were not used, and the stamp of the first.
  std::uint64_t odometryLeftBehind() const { return gate_.leftBehind(); }
  std::optional<Stamp> firstLeftBehind() const { return gate_.firstLeftBehind(); }
  /// @throws std::invalid_argument for an angle that is not finite. The check is here, because an exception in drain()
  /// would lose the decisions before it.
  EventVerdict addView(const ViewEvent& view);

  /// Decisions on the views that pass, oldest first.
  std::vector<PoseCellDecision> drain(Passing which = Passing::kReached);

  std::size_t waitingViews() const { return gate_.size(); }
  std::vector<Stamp> waitingStamps() const { return gate_.waitingStamps(); }
  /// Numbers of views that were dropped: ahead of time, and never reached by the odometry.
  std::uint64_t aheadViews() const { return gate_.aheadEvents(); }
  std::uint64_t unreachedViews() const { return gate_.unreachedEvents(); }
  /// Stamp of the newest view; none after interrupt().
  std::optional<Stamp> lastView() const { return gate_.lastEvent(); }
  /// Whether the views have gone back in time and the odometry has not yet.
  bool waitsForOdometryToGoBack() const { return gate_.waitsForOdometryToGoBack(); }
  /// Time by which the odometry lags behind the waiting view [s]; none if no view waits.
  std::optional<double> lag() const {
    const auto newest = gate_.odometry().lastStamp();
    if (gate_.waiting() == nullptr || !newest) return std::nullopt;
    return secondsBetween(*newest, gate_.waiting()->stamp);
  }
  const OdometryTimeline& odometry() const { return gate_.odometry(); }
  const PoseCells& cells() const { return cells_; }

  /// Session of the view cells' numbers. When another one begins, the ties of view cells that it does not know are
  /// forgotten.
  const NumberSession& viewSession() const { return view_session_; }

  /// Clears the streams, before another drive or another part of the same drive.
  void interrupt();
  /// Drops the views that wait, after load(): the process that saved the state went on and decided on them.
  void forgetWaiting() { gate_.forgetWaiting(); }

  /// Whether new experiences may be created.
  void setLearning(bool learning) { cells_.setLearning(learning); }

  /// Sets other parameters for all views later than `after`. Only those of changeableKeys may differ.
  /// @throws std::invalid_argument for bad ones
  void change(Stamp after, const PoseCellParams& params) {
    params.validate();
    changes_.add(after, params);
  }
  /// The stamp after which a change made now holds.
  Stamp latestProcessed() const { return changes_.latest(gate_.latestPassed()); }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state);

 private:
  PoseCellDecision process(const ViewEvent& view);

  PoseCells cells_;
  TimedChanges<PoseCellParams> changes_;
  NumberSession view_session_;
  OdometryStreamParams stream_;
  EventGate<ViewEvent> gate_;
  std::uint64_t beginnings_ = 0;  ///< times that the odometry's time had begun anew at the last view
};

}  // namespace ratslam
