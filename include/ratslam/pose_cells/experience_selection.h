/// Selection of the current experience, eq. (5). The view term acts as a gate.
///
/// An experience ties a view cell to a position in the pose cells. At each pair of odometry step and view event:
///  1. There is no experience yet, or the active view cell has none: create one.
///  2. The view cell changed, or the position is farther than exp_delta_pc_threshold from that of the current
///     experience: the nearest other experience of the active view cell becomes current if it is nearer than the
///     threshold. Otherwise create one.
///  3. In all other cases nothing happens.
///
/// With exp_density k > 0 the map grows denser where the robot comes more often. After n further visits the
/// threshold of an experience is exp_delta_pc_threshold / (1 + k ln(1 + n)): the number of experiences on a
/// stretch of road grows with the logarithm of the visits. A new experience takes over the visits of the nearest
/// one of its view. Several experiences can then share one unchanged view. The view cannot tell them apart: only
/// odometry selects among them, which is no recall (kSetNode). When a view becomes active, only experiences
/// that were created when it became active are candidates.
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

/// The view cell of an experience, and the heading at its creation relative to that of its template [rad].
struct PlaceView {
  std::uint32_t view_id = 0;
  double relative_rad = 0.0;
};

class ExperienceSelector {
 public:
  explicit ExperienceSelector(const PoseCellParams& params) : params_(params) {}

  /// The decision. With kNone source and destination are the current experience. The action's relative_rad is the
  /// heading now relative to the heading at the destination's creation: 0 for a new one.
  TopologicalAction select(const ViewEvent& view, const PoseCellEstimate& estimate);

  /// To be called when the robot goes on from an unknown position. Until a view leads to the next decision, the robot is
  /// at no experience: the one that was current is recalled as any other.
  void wakeUp() { nowhere_ = true; }

  /// Forgets the view cells with this number and higher ones, which will get other views. Their experiences are
  /// no longer recalled.
  void forgetViewsFrom(std::uint32_t view_id);

  /// The view of an experience; none if its view cell was forgotten. @throws std::out_of_range
  std::optional<PlaceView> viewOf(std::uint32_t experience) const;

  /// Number of experiences.
  std::size_t size() const { return experiences_.size(); }

  /// Whether steps 1 and 2 may create an experience. If not, the current one stays current instead.
  void setLearning(bool learning) { learning_ = learning; }
  bool learning() const { return learning_; }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing
  void load(const State& state);

  /// The decision if no view cell is active: the current experience stays current.
  TopologicalAction stay(Stamp stamp) const;

 private:
  struct Experience {
    PoseCellEstimate where;
    std::uint32_t view_id = 0;
    double relative_rad = 0.0;  ///< of the view event that created it
    std::uint32_t visits = 0;   ///< number of recalls; counted only if the threshold depends on it
    bool recognisable = true;   ///< created when its view became active, and not while the view stayed active

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("where", where);
      fields("view_id", view_id);
      fields("relative_rad", relative_rad);
      fields("visits", visits);
    }
  };

  /// Heading now minus heading at the experience's creation, by their common view cell [rad].
  double relativeHeading(const ViewEvent& view, const Experience& experience) const;
  /// Distance on the torus [cells], the heading corrected by the relative heading.
  double distance(const ViewEvent& view, const PoseCellEstimate& estimate,
                  const Experience& experience) const;
  /// Distance from an experience beyond which the place is another one [cells].
  double reach(const Experience& experience) const;
  /// Nearest experience of the view within its threshold, except that at which the robot is.
  /// @param recognised  the view has just become active
  std::optional<std::uint32_t> nearestOther(const ViewEvent& view, const PoseCellEstimate& estimate,
                                            bool recognised) const;
  /// Visits of the view's nearest experience; 0 if none is within exp_delta_pc_threshold.
  std::uint32_t visitsAround(const ViewEvent& view, const PoseCellEstimate& estimate) const;
  void indexViews();
  std::uint32_t create(const ViewEvent& view, const PoseCellEstimate& estimate, bool recognisable);

  PoseCellParams params_;
  bool learning_ = true;
  std::vector<Experience> experiences_;  ///< by id
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> of_view_;
  std::uint32_t current_ = 0;
  bool nowhere_ = false;  ///< since wakeUp(): the robot is no longer at current_
};

}  // namespace ratslam
