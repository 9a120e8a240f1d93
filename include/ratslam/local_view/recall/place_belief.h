/// Belief about the robot's place: a discrete Bayes filter over the learned places. Odometry moves the belief along the
/// links between places, and each view weighs it. One of the hypotheses is "a place not yet known".
///
/// Steps for each view:
///   1. Move (move). A place stands for the stretch of path up to the place learned next, and the robot may be anywhere
///      on it. The belief in a place moves along its links by the distance driven since the last view. The
///      length of the same stretch, as measured at two visits, may differ by a share of 0.4, or by more if the
///      odometry's covariance is larger. On a chain with one step per place, 0.1 of the belief stays, 0.8 moves to the
///      next place and 0.1 to the one after it. The place not yet known gets the belief that would pass the end of the
///      links, the belief that would move to the newest places, and a share of 0.0005 of all other belief (less if the
///      view has not changed).
///   2. Begin anywhere (seed). A share of 1e-4 of the belief in a place not yet known is distributed over the learned
///      places. Only the places most similar to the view are followed.
///   3. Veto of odometry (excluded). A place is excluded if dead reckoning puts the robot farther from it than 4
///      standard deviations of the drift since its last visit. This distinguishes identical houses in a row. For a
///      camera that looks ahead, a place is also excluded if the robot had another heading there. Without odometry, and
///      across a break in it, nothing is excluded.
///   4. Weigh (weigh). z is the likeness of a place, standardised over all places. The belief in the place is
///      multiplied by exp(0.7 n z). A place not yet known counts as z = 2.5, or as 0.8 if there is no odometry or the
///      robot was at a known place at the last view. n is the novelty of the view, from 0 to 1: of two equal views the
///      second is no further evidence, so that a chance likeness does not accumulate. If the odometry has not measured
///      all of the path since the place's last visit, or states no covariance (deadReckoningKnows), a likeness beyond
///      chance counts more, by n (z - 6)^2, so that a recall comes soon. Otherwise the recall can wait until the robot
///      is where the place was learned. The lane, a sideways shift of the view, has a belief of its own with the same
///      weights. It changes slowly. At first the lane in which the place was learned is the most likely one.
///
/// A place is claimed if it and the places within 2 links of it hold more than 0.99 of the belief. If the robot moves
/// on from a known place to the next and the odometry states its covariance, it is enough that all known places
/// together hold that much. Another place may then have up to twenty times as much belief as the claimed one: the
/// places of a road that was learned twice share the belief.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "ratslam/local_view/matcher.h"
#include "ratslam/local_view/recall/place_graph.h"

namespace ratslam {

/// Motion between two views.
struct ViewMotion {
  double forward = 0.0;   ///< [m]
  double rotation = 0.0;  ///< [rad]
  /// Variances of the two [m^2, rad^2]; none: the odometry does not state them.
  std::optional<double> forward_variance;
  std::optional<double> yaw_variance;
  std::uint32_t epoch = 0;  ///< changes when dead reckoning is broken
  /// Standard deviation of an unmeasured part of the motion [m]; 0: all of it was measured. No link is made across it.
  /// A predicted part with the odometry's own covariance counts as measured.
  double unmeasured = 0.0;
  /// There is no odometry: each view counts as one step forward, and dead reckoning excludes nothing.
  bool assumed = false;

  static ViewMotion oneStep() {
    ViewMotion motion;
    motion.forward = 1.0;
    motion.assumed = true;
    return motion;
  }
};

/// The most likely place of the robot.
struct PlaceClaim {
  std::uint32_t place = 0;
  /// Belief in the place, its neighbours within 2 links, and places with nearly the same view.
  double confidence = 0.0;
  /// Distance of the robot ahead of the place, along the path driven then, by the likeness of the neighbouring places
  /// [m]; 0 if their likeness does not determine it, the motion is not measured, or the confidence is not above kClaim.
  double ahead = 0.0;
  /// Relative likeness of each variant of the view to the place; they sum to 1.
  std::vector<double> variant_weights;
};

struct PlaceMass {
  std::uint32_t place = 0;
  double mass = 0.0;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("place", place);
    fields("mass", mass);
  }
};

inline bool byPlace(const PlaceMass& a, const PlaceMass& b) { return a.place < b.place; }

class PlaceBelief {
 public:
  /// A claimed place counts as recalled if its confidence is above this.
  static constexpr double kClaim = 0.99;

  PlaceBelief() = default;
  /// @param all_round the views do not depend on the robot's heading (panoramic camera)
  explicit PlaceBelief(bool all_round) : all_round_(all_round) {}

  /// Step 1. @param motion since the last view. @param novelty of the next view relative to the last one, 0 to 1
  /// (ViewMatcher::novelty)
  void move(const ViewMotion& motion, double novelty);

  /// Steps 2 to 4. @param candidates only places with a lower number can be recalled.
  /// @return the most likely place; none if all belief is in places not yet known.
  std::optional<PlaceClaim> weigh(const ViewLikeness& likeness, std::size_t candidates);

  /// Number of candidates of a view while the robot maps. The 10 newest places are no candidates, because the robot has
  /// just left them; nor are the places before them as long as they still look like the view. But a place is a
  /// candidate if the robot has since driven over known ground for more than 10 places: it may be back. So are all
  /// places that were known when it woke up: it may stand at the place where its last drive ended.
  std::size_t leftBehind(const ViewLikeness& likeness) const;

  /// Sets the place of the last view, which may be the next new one.
  /// @param learns  whether to add the link from the place before, if one of the two is new
  void arrive(std::uint32_t place, bool learns = true);

  /// To be called when the robot starts anew at an unknown position, most likely at one of the learned places.
  void wakeUp();

  /// The `count` most likely places, the most likely one first.
  std::vector<PlaceMass> strongest(std::size_t count) const;
  double unknown() const { return unknown_; }
  std::size_t memoryBytes() const;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("graph", graph_);
    fields("active", active_);
    fields("unknown", unknown_);
    fields("variants", variants_);
    fields("here", here_);
    fields("at", at_);
    fields("at_new", at_new_);
    fields("since_arrival", since_arrival_);
    fields("novelty_since_arrival", novelty_since_arrival_);
    fields("waking", waking_);
    fields("before", before_);
    fields("candidates", candidates_);
    fields("novelty", novelty_);
    fields("measured", measured_);
  }

 private:
  /// Mean and deviation of the likeness over all places.
  struct Spread {
    double mean = 0.0;
    double deviation = 1.0;

    double standardised(float value) const { return (static_cast<double>(value) - mean) / deviation; }
  };
  /// No link will lead from the last place to the next one.
  void leave();
  static Spread spreadOf(const ViewLikeness& likeness);
  bool atKnownPlace() const { return at_ && !at_new_; }  // at the last view
  bool excluded(std::uint32_t place) const;
  bool wayIsMeasured(std::uint32_t place) const;
  bool deadReckoningKnows(std::uint32_t place) const;
  std::optional<PlaceMass> onTheWay() const;
  double massOf(std::uint32_t place) const;
  double aheadOf(std::uint32_t place, const ViewLikeness& likeness, double faded) const;
  std::pair<std::optional<PlaceAhead>, std::optional<PlaceAhead>> neighbours(std::uint32_t place) const;
  bool facesElsewhere(const PlaceVisit& then) const;
  void handOn(const PlaceMass& from, double driven, double sigma);
  void seed(const ViewLikeness& likeness, std::size_t candidates);
  void seedEverywhere(std::size_t candidates);
  void collect(std::size_t places);
  std::optional<PlaceClaim> claim(const ViewLikeness& likeness, const Spread& spread) const;

  bool all_round_ = false;
  PlaceGraph graph_;
  std::vector<PlaceMass> active_;  // places with belief, ascending
  double unknown_ = 1.0;           // belief in a place not yet known
  std::vector<double> variants_;   // belief in each variant of the view
  DeadReckoning here_;
  std::optional<std::uint32_t> at_;     // place of the last view
  bool at_new_ = false;                 // it was learned at the last view
  double step_ = 0.0;                   // distance of the last move [m]
  double since_arrival_ = 0.0;          // distance driven since arrive() [m]
  double novelty_since_arrival_ = 0.0;  // sum of the views' novelty since arrive()
  bool waking_ = false;                 // no view since wakeUp()
  std::uint32_t before_ = 0;            // places that were known at the last wakeUp()
  std::size_t candidates_ = 0;          // of the last view
  double novelty_ = 1.0;                // of the view since the last move
  bool measured_ = false;               // odometry has measured the last move
  // Buffers.
  std::vector<PlaceMass> added_;
  std::vector<PlaceAhead> around_;
};

}  // namespace ratslam
