/// View cell input to the pose cells, eq. (3). A new view is tied to the present estimate ("one-shot" learning,
/// beta). A recalled view injects activity at the position to which it is tied.
///
/// At each view event:
///  1. An unknown id is tied to the present estimate.
///  2. A known id that is not among the 10 most recently tied, or was tied before wakeUp(), injects
///     energy * (30 - exp(1.2 d)) / 30, if that is positive. d is the saturation of the id. Its rest value is
///     vt_active_decay, and it grows by that value each time the id repeats.
///     With pc_openratslam_injection all of it goes to one cell, at the coordinates of the tie without their
///     fractions. This draws the packet up to a cell away from the tie, along each axis.
///  3. Every id's saturation falls by pc_vt_restore towards the rest value.
/// Saturation prevents false relocalisation while the robot stands still. It is updated when its id is seen and
/// not at each event.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "ratslam/events.h"
#include "ratslam/pose_cells/activity_grid.h"
#include "ratslam/pose_cells/params.h"

namespace ratslam {

class State;

/// Activity that a recalled view adds.
struct Injection {
  PoseCellEstimate where;
  double energy = 0.0;
};

class ViewInput {
 public:
  explicit ViewInput(const PoseCellParams& params) : params_(params) {}

  /// Processes a view event. An id is new if this object has not seen it; the event's flag is not used, because
  /// a recorded topic has none. @param estimate present best estimate. @return the injection, if there is one.
  std::optional<Injection> onView(const ViewEvent& event, const PoseCellEstimate& estimate);

  /// To be called when the robot goes on from an unknown position. All ids known now are at rest, and inject when they
  /// are recalled, also those tied last: the robot may have come back to them.
  void wakeUp();

  /// Forgets the ties of the view cells with this number and higher ones, which will get other views.
  void forgetFrom(std::uint32_t view_id);

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing
  void load(const State& state);

 private:
  struct Tie {
    PoseCellEstimate where;
    double saturation = 0.0;    ///< after event number `updated`
    std::uint64_t updated = 0;  ///< number of the event at which the saturation was updated last
    std::uint64_t order = 0;    ///< number of ids tied before

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("where", where);
      fields("saturation", saturation);
      fields("updated", updated);
      fields("order", order);
    }
  };

  /// A tie and its view cell, as a row.
  struct TiedView {
    std::uint32_t view_id = 0;
    Tie tie;

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("view_id", view_id);
      fields("tie", tie);
    }
  };

  std::optional<Injection> recall(Tie& tie, const ViewEvent& event) const;
  void restore(Tie& tie) const;

  PoseCellParams params_;
  std::unordered_map<std::uint32_t, Tie> ties_;
  std::optional<std::uint32_t> previous_id_;
  std::uint64_t events_ = 0;        ///< number of complete events
  std::uint64_t known_before_ = 0;  ///< ids that were tied at the last wakeUp()
};

}  // namespace ratslam
