/// Pose cells fed by two stamped streams: odometry and view events.
///
/// A view event is processed once the odometry has reached its stamp; all motion since the view before it
/// makes one attractor iteration (so a faster odometry changes nothing but its accuracy), then the view cell
/// acts, then the decision is taken. The result depends on stamps and values alone.
#pragma once

#include <vector>

#include "ratslam/events.h"
#include "ratslam/pose_cells/pose_cells.h"
#include "ratslam/system/event_gate.h"
#include "ratslam/system/parameter_changes.h"

namespace ratslam {

/// Everything the pose cells say about one view event.
struct PoseCellDecision {
  ViewEvent view;
  TopologicalAction action;  ///< kind kNone where nothing is to do; its stamp is the view's
  PoseCellEstimate estimate;
};

class PoseCellStage {
 public:
  explicit PoseCellStage(const PoseCellParams& params, const OdometryStreamParams& stream = {})
      : cells_(params), stream_(stream), gate_(false, stream) {}

  SampleVerdict addOdometry(const OdometrySample& sample) { return gate_.addOdometry(sample); }
  /// @throws std::invalid_argument for an angle that is not finite: where it passed, the decisions before it would be lost
  EventVerdict addView(const ViewEvent& view);

  /// Decisions on the views that pass, oldest first.
  std::vector<PoseCellDecision> drain(Passing which = Passing::kReached);

  std::size_t waitingViews() const { return gate_.size(); }
  /// Whether the views have gone back in time and the odometry has not, so far.
  bool waitsForOdometryToGoBack() const { return gate_.waitsForOdometryToGoBack(); }
  /// How far the odometry lags behind the view that waits for it [s]; none where none waits.
  std::optional<double> lag() const {
    const auto newest = gate_.odometry().lastStamp();
    if (gate_.waiting() == nullptr || !newest) return std::nullopt;
    return secondsBetween(*newest, gate_.waiting()->stamp);
  }
  const OdometryTimeline& odometry() const { return gate_.odometry(); }
  const PoseCells& cells() const { return cells_; }

  /// Session of the view cells' numbers. When another one begins, what was tied to view cells that it does not
  /// know is forgotten.
  const NumberSession& viewSession() const { return view_session_; }

  /// Forgets what the streams have brought: what comes next is another drive, or another part of this one.
  void interrupt();

  /// Whether places may become experiences.
  void setLearning(bool learning) { cells_.setLearning(learning); }

  /// Other parameters for all views later than `after`: those of changeableKeys may differ.
  /// @throws std::invalid_argument for bad ones
  void change(Stamp after, const PoseCellParams& params) {
    params.validate();
    changes_.add(after, params);
  }
  /// The stamp after which a change that is made now would hold.
  Stamp latestProcessed() const { return gate_.latestPassed(); }

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
};

}  // namespace ratslam
