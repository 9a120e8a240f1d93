/// Which experience the robot is at, eq. (5), the view term acting as a gate.
///
/// An experience ties a view cell to a place in the pose cells. At each pair of odometry step and view event:
///  1. no experience yet, or the active view cell has none: create one;
///  2. the view cell changed, or the place is farther than
///     exp_delta_pc_threshold from the current experience's: the nearest other
///     experience of the active view cell becomes current if nearer than the
///     threshold, else create one;
///  3. otherwise nothing happens.
///
/// With exp_density k > 0 the map grows denser where experience is richer: the threshold of an experience at which the
/// robot has come to be n times more is exp_delta_pc_threshold / (1 + k ln(1 + n)), so that a stretch of way has a number of
/// experiences that grows with the logarithm of the visits. One that is created between known ones of its view has
/// the visits of the nearest. Of those that are made while a view stays the view says nothing: which of them the robot comes to
/// is a matter of odometry alone, and no recall (kSetNode). A view that becomes active leads to one that was made when it
/// became active.
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

/// The view cell of an experience, and the heading there relative to that at which its template was learned [rad].
struct PlaceView {
  std::uint32_t view_id = 0;
  double relative_rad = 0.0;
};

class ExperienceSelector {
 public:
  explicit ExperienceSelector(const PoseCellParams& params) : params_(params) {}

  /// The decision; source and destination of kNone are the current experience. `relative_rad` of the action
  /// is the heading now relative to the heading at which the destination was created: 0 for a new one.
  TopologicalAction select(const ViewEvent& view, const PoseCellEstimate& estimate);

  /// Experiences of view cells from a number on are not recognised again: these will stand for other views.
  void forgetViewsFrom(std::uint32_t view_id);

  /// None where the view of an experience is known no more. @throws std::out_of_range
  std::optional<PlaceView> viewOf(std::uint32_t experience) const;

  /// How many experiences there are.
  std::size_t size() const { return experiences_.size(); }

  /// Whether step 1 and 2 may create an experience; else the current one stays where they would.
  void setLearning(bool learning) { learning_ = learning; }
  bool learning() const { return learning_; }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing
  void load(const State& state);

  /// The decision where no view cell is active: to stay with the current experience.
  TopologicalAction stay(Stamp stamp) const;

 private:
  struct Experience {
    PoseCellEstimate where;
    std::uint32_t view_id = 0;
    double relative_rad = 0.0;  ///< of the view event that created it
    std::uint32_t visits = 0;   ///< how often it was recalled; counted where the threshold depends on it
    bool recognisable = true;   ///< made when its view became active; else while it stayed (exp_density)

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("where", where);
      fields("view_id", view_id);
      fields("relative_rad", relative_rad);
      fields("visits", visits);
    }
  };

  /// Heading now minus heading at the experience's creation, as their one view cell saw it [rad].
  double relativeHeading(const ViewEvent& view, const Experience& experience) const;
  /// Distance on the torus [cells], the heading corrected by the relative heading.
  double distance(const ViewEvent& view, const PoseCellEstimate& estimate,
                  const Experience& experience) const;
  /// Distance from an experience beyond which a place is another one [cells].
  double reach(const Experience& experience) const;
  /// @param recognised  the view has become active
  std::optional<std::uint32_t> nearestOther(const ViewEvent& view, const PoseCellEstimate& estimate,
                                            bool recognised) const;
  /// Visits of the experience of a view that is nearest, within the distance that holds without visits.
  std::uint32_t visitsAround(const ViewEvent& view, const PoseCellEstimate& estimate) const;
  void indexViews();
  std::uint32_t create(const ViewEvent& view, const PoseCellEstimate& estimate, bool recognisable);

  PoseCellParams params_;
  bool learning_ = true;
  std::vector<Experience> experiences_;  ///< by id
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> of_view_;
  std::uint32_t current_ = 0;
};

}  // namespace ratslam
