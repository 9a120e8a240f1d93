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

namespace ratslam {

/// Everything the pose cells say about one view event.
struct PoseCellDecision {
  ViewEvent view;
  TopologicalAction action;  ///< kind kNone where nothing is to do; its stamp is the view's
  PoseCellEstimate estimate;
};

class PoseCellStage {
 public:
  explicit PoseCellStage(const PoseCellParams& params) : cells_(params), gate_(false) {}

  /// kTimeWentBack has already reset the stream; the sample that told so sets the clock anew.
  SampleVerdict addOdometry(const OdometrySample& sample) { return gate_.addOdometry(sample); }
  /// @return false where the view's stamp lies before the one before it
  bool addView(const ViewEvent& view) { return gate_.addEvent(view); }

  /// Decisions that have become possible, oldest first.
  std::vector<PoseCellDecision> drain();

  /// Processes the waiting views with the motion known so far: for a live odometry that has fallen silent.
  std::vector<PoseCellDecision> drainWithoutOdometry();

  std::size_t waitingViews() const { return gate_.size(); }
  const PoseCells& cells() const { return cells_; }

  /// Session of the view cells' numbers. When another one begins, what was tied to view cells that it does not
  /// know is forgotten.
  const NumberSession& viewSession() const { return view_session_; }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state);

 private:
  PoseCellDecision process(const ViewEvent& view);

  PoseCells cells_;
  NumberSession view_session_;
  EventGate<ViewEvent> gate_;
};

}  // namespace ratslam
