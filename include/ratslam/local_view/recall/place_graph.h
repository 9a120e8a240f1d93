/// Graph of the places where views were learned: the paths between them with their lengths, and the dead reckoning at
/// the last visit of each place.
///
/// Most places are linked to the place learned after them. The place itself holds that link; a table holds all others.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace ratslam {

/// Pose of the robot by dead reckoning. Poses of different epochs cannot be compared.
struct DeadReckoning {
  double x = 0.0;  ///< [m]
  double y = 0.0;
  double way = 0.0;               ///< distance driven so far [m]
  double forward_variance = 0.0;  ///< of that distance, as stated by the odometry; 0: not stated [m^2]
  double yaw_variance = 0.0;      ///< of the heading, likewise [rad^2]
  double heading = 0.0;           ///< sum of the turns [rad]
  double turned = 0.0;            ///< sum of their absolute values [rad]
  std::uint32_t epoch = 0;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("x", x);
    fields("y", y);
    fields("way", way);
    fields("forward_variance", forward_variance);
    fields("yaw_variance", yaw_variance);
    fields("heading", heading);
    fields("turned", turned);
    fields("epoch", epoch);
  }
};

/// Dead reckoning at the last visit of a place, in few bytes, and the link to the place learned next.
struct PlaceVisit {
  float x = 0.0F;  ///< [m]
  float y = 0.0F;
  float forward_variance = 0.0F;
  float yaw_variance = 0.0F;
  float heading = 0.0F;  ///< [rad]
  float turned = 0.0F;   ///< [rad]
  double way = 0.0;      ///< [m]
  std::uint32_t epoch = 0;
  float to_next = -1.0F;  ///< length of the path to the place learned next [m]; negative: no link
  float novelty = 1.0F;   ///< sum of the novelty of the views on that path

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("x", x);
    fields("y", y);
    fields("forward_variance", forward_variance);
    fields("yaw_variance", yaw_variance);
    fields("heading", heading);
    fields("turned", turned);
    fields("way", way);
    fields("epoch", epoch);
    fields("to_next", to_next);
    fields("novelty", novelty);
  }
};

/// A place at a distance ahead of another one [m]; negative: behind it.
struct PlaceAhead {
  std::uint32_t place = 0;
  double distance = 0.0;
};

class PlaceGraph {
 public:
  std::size_t size() const { return visits_.size(); }
  /// Adds the next place.
  void add() { visits_.emplace_back(); }
  void visit(std::uint32_t place, const DeadReckoning& where);
  const PlaceVisit& lastVisit(std::uint32_t place) const { return visits_[place]; }

  /// Adds a link for a driven path. Does nothing if the places are linked already.
  /// @param distance  length of the path [m]  @param novelty  sum of its views' novelty (ViewMatcher::novelty)
  void link(std::uint32_t from, std::uint32_t to, double distance, double novelty);

  /// Places within `ahead` and `behind` metres along the links, this one included, each once. At least the direct
  /// neighbours, at most a few dozen.
  void around(std::uint32_t place, double behind, double ahead, std::vector<PlaceAhead>& found) const;

  /// Places at most `links` links away, and places with a total novelty of less than `novelty` in between. This one is
  /// included. At most a few dozen.
  void within(std::uint32_t place, int links, double novelty, std::vector<std::uint32_t>& found) const;

  /// Mean length of the links of a place [m]; 0 if it has none.
  double spacing(std::uint32_t place) const;

  /// Length of the stretch of path that a place stands for [m]: the mean distance to the next places with numbers below
  /// `end`. If there are none, the distance from the place before, but at least `least`.
  double stretch(std::uint32_t place, double least, std::size_t end) const;

  std::size_t memoryBytes() const;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("visits", visits_);
    fields("links", links_);
    indexLinks();
  }

 private:
  /// A link to another place than the one learned next.
  struct Link {
    std::uint32_t from = 0;
    std::uint32_t to = 0;
    double distance = 0.0;

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("from", from);
      fields("to", to);
      fields("distance", distance);
    }
  };

  void indexLinks();
  template <class Visit>
  void eachNeighbour(std::uint32_t place, Visit&& visit) const;

  std::vector<PlaceVisit> visits_;
  std::vector<Link> links_;
  std::unordered_multimap<std::uint32_t, PlaceAhead> others_;  // links_ by either end
};

}  // namespace ratslam
