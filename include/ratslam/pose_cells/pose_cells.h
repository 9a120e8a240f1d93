/// Pose cells: a continuous attractor network that integrates odometry and is corrected by recalled views (eqs.
/// (1)-(3)). It also decides which experience is current and when a place is a new one (eq. (5)). Source:
/// docs/theory.md.
///
/// Order within a frame: integrate (the odometry step), activate (the view event), decide. The first odometry
/// message only sets the caller's clock: so the first frame has a view event, but no step and no decision.
#pragma once

#include <cstdint>
#include <optional>

#include "ratslam/events.h"
#include "ratslam/pose_cells/activity_grid.h"
#include "ratslam/pose_cells/experience_selection.h"
#include "ratslam/pose_cells/network.h"
#include "ratslam/pose_cells/params.h"
#include "ratslam/pose_cells/view_input.h"

namespace ratslam {

class PoseCells {
 public:
  /// @throws std::invalid_argument as PoseCellParams::validate.
  explicit PoseCells(const PoseCellParams& params)
      : network_(params), view_input_(params), selector_(params) {}

  /// One attractor iteration and path integration.
  /// @param distance [m] along the heading, negative backwards; @param rotation [rad], counter-clockwise
  /// positive.
  /// @throws std::invalid_argument if either is not finite. Nothing has changed then.
  void integrate(double distance, double rotation) { network_.step(distance, rotation); }

  /// Ties a new view cell to the present estimate, or injects activity at the position of a known one. An event
  /// without a view (kNoView) does neither.
  /// @throws std::invalid_argument if the event's relative_rad is not finite. Nothing has changed then.
  void activate(const ViewEvent& event);

  /// The decision for the last odometry step and view event, with the event's stamp. If nothing is to be done it
  /// is kNone, with the current experience as source and destination.
  TopologicalAction decide();

  PoseCellEstimate estimate() const { return network_.estimate(); }
  const ActivityGrid& activity() const { return network_.activity(); }
  /// Number of times that all activity had died and the network restarted at the last best estimate.
  std::uint64_t reseeds() const { return network_.reseeds(); }

  /// To be called when the robot goes on from an unknown position: ViewInput::wakeUp and ExperienceSelector::wakeUp.
  void wakeUp();
  /// Forgets the ties of the view cells with this number and higher ones, which will get other views.
  void forgetViewsFrom(std::uint32_t view_id);
  std::optional<PlaceView> viewOf(std::uint32_t experience) const { return selector_.viewOf(experience); }
  /// Number of experiences created.
  std::size_t experiences() const { return selector_.size(); }

  /// Whether new experiences may be created. If not, only known ones become current.
  void setLearning(bool learning) { selector_.setLearning(learning); }
  bool learning() const { return selector_.learning(); }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state);

 private:
  PoseCellNetwork network_;
  ViewInput view_input_;
  ExperienceSelector selector_;
  std::optional<ViewEvent> view_;
};

}  // namespace ratslam
