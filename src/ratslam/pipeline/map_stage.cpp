#include "ratslam/pipeline/map_stage.h"

namespace ratslam {

MapStage::MapStage(const ExperienceMapParams& params, bool wait_for_geometry)
    : map_(params), wait_for_geometry_(wait_for_geometry), gate_(params.exp_height) {}

bool MapStage::addDecision(const TopologicalAction& action) {
  const bool forward = gate_.addEvent(action);
  if (!forward) started_ = false;  // the map's clock is set anew: no motion, no time across the jump
  return forward;
}

std::vector<Stamp> MapStage::drain() {
  std::vector<Stamp> processed;
  while (const TopologicalAction* next = gate_.ready()) {
    if (wait_for_geometry_ && geometry_.count(next->stamp) == 0) break;
    const TopologicalAction action = *next;
    gate_.pop();
    process(action);
    processed.push_back(action.stamp);
  }
  return processed;
}

std::vector<Stamp> MapStage::drainWithoutWaiting() {
  std::vector<Stamp> processed;
  while (const TopologicalAction* next = gate_.waiting()) {
    const TopologicalAction action = *next;
    gate_.pop();
    process(action);
    processed.push_back(action.stamp);
  }
  return processed;
}

void MapStage::process(const TopologicalAction& action) {
  if (!started_) {
    map_.start(gate_.clockStart().value_or(action.stamp));
    started_ = true;
  }
  for (const TimedStep& timed : gate_.motionUntil(action.stamp)) map_.integrate(timed.end, timed.step);
  const auto measured = geometry_.find(action.stamp);
  const bool usable = measured != geometry_.end() && measured->second.inliers > 0;
  const std::optional<RecallGeometry> geometry =
      usable ? std::optional<RecallGeometry>(measured->second) : std::nullopt;
  if (measured != geometry_.end()) geometry_.erase(geometry_.begin(), std::next(measured));
  if (action.kind != ActionKind::kNone) map_.apply(action, geometry ? &*geometry : nullptr);
}

}  // namespace ratslam
