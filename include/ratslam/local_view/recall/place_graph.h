/// The places that views were learned at, as far as recalling them goes: which way leads from one to which
/// next, how far it is, and where dead reckoning had them when they were last visited.
///
/// Most places are left for the place learned after them: that link is kept with the place, others in a table.
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace ratslam {

/// Where dead reckoning has the robot. Its frame means nothing across epochs.
struct DeadReckoning {
  double x = 0.0;  ///< [m]
  double y = 0.0;
  double way = 0.0;               ///< driven so far [m]
  double forward_variance = 0.0;  ///< of the way, as far as the odometry says [m^2]
  double yaw_variance = 0.0;      ///< of the heading [rad^2]
  double heading = 0.0;           ///< [rad], turns added up
  double turned = 0.0;            ///< by so much in all, to either side [rad]
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

/// What a visit leaves with a place, in few bytes.
struct PlaceVisit {
  float x = 0.0F;  ///< [m]
  float y = 0.0F;
  float forward_variance = 0.0F;
  float yaw_variance = 0.0F;
  float heading = 0.0F;  ///< [rad]
  float turned = 0.0F;   ///< [rad]
  double way = 0.0;      ///< [m]
  std::uint32_t epoch = 0;
  float to_next = -1.0F;  ///< way to the place learned next [m]; negative: it was not driven
  float novelty = 1.0F;   ///< of the views from this place to the place learned next, added up

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

/// A place reached from another, `distance` ahead of it (negative: behind).
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

  /// The way from one place to another was driven. A second time changes nothing.
  /// @param novelty  of the views on the way, added up (ViewMatcher::novelty)
  void link(std::uint32_t from, std::uint32_t to, double distance, double novelty);

  /// Places within `ahead` and `behind` metres along the links, this one included, each once, at its shortest
  /// distance on either side; at least the next link's either way, at most a few dozen.
  void around(std::uint32_t place, double behind, double ahead, std::vector<PlaceAhead>& found) const;

  /// Places at most `links` links away, and those so near that the views between add up to less than `novelty`;
  /// this one included, at most a few dozen.
  void within(std::uint32_t place, int links, double novelty, std::vector<std::uint32_t>& found) const;

  /// Mean length of the links at this place [m]; 0 where it has none.
  double spacing(std::uint32_t place) const;

  /// Length of the way from this place to the next of a number below `end`, the mean where there are several;
  /// where there is none, that from the one before, but not less than `least` [m].
  double stretch(std::uint32_t place, double least, std::size_t end) const;

  std::size_t memoryBytes() const;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("visits", visits_);
    fields("links", links_);
    indexLinks();
  }

 private:
  /// A link that is not to the place learned next.
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
  std::unordered_multimap<std::uint32_t, PlaceAhead> others_;  // links_ from both ends
};

}  // namespace ratslam
