#include "ratslam/pose_cells/pose_cells.h"

#include <cmath>

namespace ratslam {

void PoseCells::activate(const ViewEvent& event) {
  if (!std::isfinite(event.relative_rad))
    throwBadValue("relative_rad", event.relative_rad, "it must be finite");
  const std::optional<Injection> injection = view_input_.onView(event, network_.estimate());
  if (injection) network_.inject(injection->cell, injection->energy);
  view_ = event;
}

TopologicalAction PoseCells::decide() {
  if (!view_) return {};
  return selector_.select(*view_, network_.estimate());
}

}  // namespace ratslam
