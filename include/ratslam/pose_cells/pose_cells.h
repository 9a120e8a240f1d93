/// Pose cells: a continuous attractor network that keeps the robot's place by integrating odometry and
/// corrects it by recalled views (eqs. (1)-(3)), and decides when a place is a new experience (eq. (5)).
/// Source: docs/theory.md.
///
/// Within a frame: integrate (the odometry step), activate (the view event), decide. The first odometry
/// message only sets the caller's clock: on the first frame there is a view event, but neither a step nor a
/// decision.
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
  /// @throws std::invalid_argument if either is not finite; nothing has changed then.
  void integrate(double distance, double rotation) { network_.step(distance, rotation); }

  /// Ties a new view cell to the present estimate, or injects activity where a known one is tied. An event
  /// without a view (kNoView) does neither.
  /// @throws std::invalid_argument if the event's relative_rad is not finite; nothing has changed then.
  void activate(const ViewEvent& event);

  /// The decision for the odometry step and view event just seen; kNone where nothing is to do, source and
  /// destination then being the current experience. The stamp is the event's.
  TopologicalAction decide();

  PoseCellEstimate estimate() const { return network_.estimate(); }
  const ActivityGrid& activity() const { return network_.activity(); }
  /// How often all activity had died and the network was started again at the last best estimate.
  std::uint64_t reseeds() const { return network_.reseeds(); }

  /// View cells from a number on will stand for other views: what is tied to them is forgotten.
  void forgetViewsFrom(std::uint32_t view_id);
  std::optional<PlaceView> viewOf(std::uint32_t experience) const { return selector_.viewOf(experience); }
  /// How many experiences have been created.
  std::size_t experiences() const { return selector_.size(); }

  /// Whether places may become experiences; else only known ones become current.
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
