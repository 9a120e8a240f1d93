#include "ratslam/system/pose_cell_stage.h"

#include <cmath>
#include <utility>

#include "ratslam/common/params.h"
#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr std::uint32_t kStateVersion = 6;

}  // namespace

EventVerdict PoseCellStage::addView(const ViewEvent& view) {
  if (!std::isfinite(view.relative_rad)) {
    throwBadValue("relative_rad", view.relative_rad, "it must be finite");
  }
  return gate_.addEvent(view);
}

std::vector<PoseCellDecision> PoseCellStage::drain(Passing which) {
  std::vector<PoseCellDecision> decisions;
  if (which == Passing::kAll) gate_.acceptHeld();
  gate_.pass(which, [&](const ViewEvent& view) {
    decisions.push_back(process(view));
    return true;
  });
  return decisions;
}

void PoseCellStage::interrupt() {
  gate_ = EventGate<ViewEvent>(false, stream_);
  beginnings_ = 0;
  cells_.wakeUp();
}

void PoseCellStage::save(State& state) const {
  state.setVersion(kStateVersion);
  cells_.save(state.child("cells"));
  state.set("streams", gate_);
  state.set("view_session", view_session_);
  state.set("beginnings", beginnings_);
}

void PoseCellStage::load(const State& state) {
  state.requireVersion(kStateVersion);
  cells_.load(state.child("cells"));
  state.get("streams", gate_);
  state.get("view_session", view_session_);
  state.get("beginnings", beginnings_);
}

PoseCellDecision PoseCellStage::process(const ViewEvent& view) {
  if (view.session.id != 0 && view.session != view_session_) {
    if (view_session_.id != 0) cells_.forgetViewsFrom(view.session.known);
    view_session_ = view.session;
  }
  if (std::exchange(beginnings_, gate_.beginnings()) != gate_.beginnings()) cells_.wakeUp();
  changes_.applyBefore(view.stamp, cells_);
  double distance = 0.0;
  double rotation = 0.0;
  const auto steps = gate_.motionUntil(view.stamp);
  for (const TimedStep& timed : steps) {
    distance += timed.step.forward;
    rotation += timed.step.rotation;
  }
  if (!steps.empty()) cells_.integrate(distance, rotation);
  cells_.activate(view);
  PoseCellDecision decision;
  decision.view = view;
  decision.action.stamp = view.stamp;
  if (!steps.empty()) decision.action = cells_.decide();
  decision.estimate = cells_.estimate();
  return decision;
}

}  // namespace ratslam
