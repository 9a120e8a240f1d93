#include "ratslam/pose_cells/pose_cells.h"

#include <cmath>

#include "ratslam/common/state.h"

namespace ratslam {

void PoseCells::activate(const ViewEvent& event) {
  if (!std::isfinite(event.relative_rad))
    throwBadValue("relative_rad", event.relative_rad, "it must be finite");
  view_ = event;
  if (!event.seen()) return;
  const std::optional<Injection> injection = view_input_.onView(event, network_.estimate());
  if (injection) network_.injectAt(injection->where, injection->energy);
}

void PoseCells::wakeUp() {
  view_input_.wakeUp();
  selector_.wakeUp();
}

void PoseCells::forgetViewsFrom(std::uint32_t view_id) {
  view_input_.forgetFrom(view_id);
  selector_.forgetViewsFrom(view_id);
}

void PoseCells::save(State& state) const {
  network_.save(state.child("network"));
  view_input_.save(state.child("view_input"));
  selector_.save(state.child("selector"));
  state.set("view", view_);
}

void PoseCells::load(const State& state) {
  network_.load(state.child("network"));
  view_input_.load(state.child("view_input"));
  selector_.load(state.child("selector"));
  state.get("view", view_);
}

TopologicalAction PoseCells::decide() {
  if (!view_) return {};
  if (!view_->seen()) return selector_.stay(view_->stamp);
  return selector_.select(*view_, network_.estimate());
}

}  // namespace ratslam
