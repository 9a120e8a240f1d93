/// View cell input to the pose cells, eq. (3): a new view is tied to where the robot is ("one-shot" learning,
/// beta); a view that is seen again injects activity where it was tied.
///
/// At each view event:
///  1. an unknown id is tied to the present estimate;
///  2. a known id that is not among the 10 most recently tied injects energy * (30 - exp(1.2 d)) / 30, where
///     positive, d being its saturation: it rests at vt_active_decay and grows by as much with each
///     repetition;
///  3. every id's saturation falls by pc_vt_restore towards its rest. Saturation keeps a standing robot from
///     relocalising falsely. It is brought up to date when its id is seen, not swept at each event.
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

/// Activity that a recalled view adds to one cell.
struct Injection {
  PoseCell cell;
  double energy = 0.0;
};

class ViewInput {
 public:
  explicit ViewInput(const PoseCellParams& params) : params_(params) {}

  /// Whether an id is new is decided by the ids seen here, not by the event's flag: a recorded topic has
  /// none.
  /// @param estimate where the robot is now. @return what to inject, if anything.
  std::optional<Injection> onView(const ViewEvent& event, const PoseCellEstimate& estimate);

  /// Forgets the ties of view cells from a number on: they will stand for other views.
  void forgetFrom(std::uint32_t view_id);

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing
  void load(const State& state);

 private:
  struct Tie {
    PoseCellEstimate where;
    double saturation = 0.0;    ///< at the end of event `updated`
    std::uint64_t updated = 0;  ///< number of the event
    std::uint64_t order = 0;    ///< how many ids were tied before

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
  std::uint64_t events_ = 0;  ///< that have ended
};

}  // namespace ratslam
