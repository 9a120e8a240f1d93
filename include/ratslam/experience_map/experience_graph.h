/// The topological graph: experiences e_i = {P^i, V^i, p^i} of equation (4) and the links between them.
///
/// This part holds the poses p^i; experience_selection.h of the pose cells holds P^i and V^i. Experiences and
/// links are plain records in flat arrays: a copy for publishing costs two memory copies. The links of an
/// experience form lists that are threaded through the link records. Nothing is ever removed. `revision()`
/// changes whenever a pose or a record changes, the two sizes whenever something is added.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "ratslam/experience_map/map_pose.h"

namespace ratslam {

class State;

constexpr std::uint32_t kNoLink = std::numeric_limits<std::uint32_t>::max();

/// A place of the map. Its id is its index.
struct Experience {
  MapPose pose;
  std::uint32_t first_outgoing = kNoLink;  ///< oldest link that starts here
  std::uint32_t last_outgoing = kNoLink;
  std::uint32_t first_incoming = kNoLink;  ///< oldest link that ends here
  std::uint32_t last_incoming = kNoLink;

  /// The lists are not saved: they follow from the order of the links.
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("pose", pose);
  }
};

/// A measured motion between two experiences, in the frame of `from`. Its id is its index.
struct Link {
  std::uint32_t from = 0;
  std::uint32_t to = 0;
  double distance = 0.0;     ///< in the odometry's unit
  double heading_rad = 0.0;  ///< direction of the displacement relative to the heading of `from`
  double facing_rad = 0.0;   ///< change of heading
  double rise = 0.0;         ///< change of height, in the odometry's unit
  double duration_s = 0.0;   ///< time from leaving `from` to reaching `to`, without stops (measuredLink)
  bool recall = false;       ///< `to` was recalled; else it was created when the link was made
  std::uint32_t next_outgoing = kNoLink;  ///< next younger link that starts at `from`
  std::uint32_t next_incoming = kNoLink;  ///< next younger link that ends at `to`

  /// Without the lists, which follow from the order of the links.
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("from", from);
    fields("to", to);
    fields("distance", distance);
    fields("heading_rad", heading_rad);
    fields("facing_rad", facing_rad);
    fields("rise", rise);
    fields("duration_s", duration_s);
    fields("recall", recall);
  }
};

class ExperienceGraph {
 public:
  const std::vector<Experience>& experiences() const { return experiences_; }
  const std::vector<Link>& links() const { return links_; }
  std::uint64_t revision() const { return revision_; }

  /// @throws std::out_of_range if there is no such experience.
  const MapPose& pose(std::uint32_t id) const { return experiences_.at(id).pose; }

  /// @return the new experience's id.
  std::uint32_t addExperience(const MapPose& pose);

  /// Appends a link and enters it in the lists of its ends. @return its id.
  /// @throws std::invalid_argument if an end does not exist or both ends are the same.
  std::uint32_t addLink(Link link);

  /// Whether a link joins the two, in either direction.
  bool linked(std::uint32_t a, std::uint32_t b) const;

  /// Replaces the pose of each experience by `pose_of(id)`.
  template <class PoseOf>
  void setPoses(PoseOf&& pose_of) {
    for (std::uint32_t id = 0; id < experiences_.size(); ++id) experiences_[id].pose = pose_of(id);
    ++revision_;
  }

  /// Calls `visit(link_id)` for the links that start at an experience, oldest first, then for those that end
  /// there.
  template <class Visit>
  void forEachLinkOf(std::uint32_t id, Visit&& visit) const {
    const Experience& experience = experiences_[id];
    for (std::uint32_t k = experience.first_outgoing; k != kNoLink; k = links_[k].next_outgoing) visit(k);
    for (std::uint32_t k = experience.first_incoming; k != kNoLink; k = links_[k].next_incoming) visit(k);
  }

  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit
  void load(const State& state);

 private:
  bool linkStarts(std::uint32_t from, std::uint32_t to) const;

  std::vector<Experience> experiences_;
  std::vector<Link> links_;
  std::uint64_t revision_ = 0;
};

}  // namespace ratslam
