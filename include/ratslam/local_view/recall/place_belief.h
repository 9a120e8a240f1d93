/// Where among the learned places the robot may be: a belief that odometry moves along the ways driven and
/// each view weighs. One of the possibilities is a place that is not yet known.
///
/// For each view:
///   1. Move (move). A place stands for the stretch of way from where it was learned to where the next one was: the
///      robot may be anywhere on it. Its belief goes on along its links by the way driven since the last view. That way
///      may be longer or shorter than the one driven then by 0.4 of itself, or by more if the odometry says so. On a
///      chain with one step a place, 0.1 of the belief stays, 0.8 goes to the next place and 0.1 to the one after it.
///      Belief that would leave the links goes to the place not yet known, and so does a two-thousandth of all other
///      belief (less where the view has not changed). Links to the newest places are not followed: that belief goes
///      to the place not yet known, too.
///   2. Begin anywhere (seed). Of the belief in a place not yet known, a share of 1e-4 is spread over the learned
///      places; only those that look most like the view are followed.
///   3. Veto of odometry (excluded). A place is excluded if dead reckoning puts the robot farther from it than 4
///      standard deviations of the drift since its last visit. This tells identical houses in a row apart. With a
///      camera that looks ahead, a place is also excluded if the robot faced another way there. Nothing is excluded
///      without odometry, or across a break of it.
///   4. Weigh (weigh). z is the likeness of a place, standardised over all places. Belief in the place is multiplied by
///      exp(0.7 n z); belief in a place not yet known as if its z were 2.5, or 0.8 if no odometry measures the way or
///      the robot was at a known place one view ago. n, from 0 to 1, is the share of the view that the last view did not
///      show: of two equal views the second is no further evidence, so a chance likeness does not add up.
///      If dead reckoning does not vouch for the way from the place (deadReckoningKnows), a likeness beyond chance
///      counts for more, by n (z - 6)^2, so that a recall comes soon. If it does, the recall can wait until the robot
///      is where the place was learned.
///      The sideways shift of the view (the lane) is believed in the same way. It changes slowly, and the lane in
///      which the place was learned is the likeliest at first.
///
/// A place is claimed if it and the places within 2 links of it hold more than 0.99 of the belief. A robot that goes on
/// from a known place to the next is there as soon as all known places together hold that much, if the odometry says
/// how well it knows its way. Then another place may hold up to twenty times as much: places of one road that were
/// learned twice share the belief.
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
  double confidence =
      0.0;  ///< belief in the place, its neighbours within 2 links, and places with nearly the same view
  /// Distance of the robot ahead of the place, along the path driven then, by the likeness of the neighbouring places
  /// [m]; 0 if they do not tell, the motion is not measured, or the confidence is not above kClaim.
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
  /// candidate if the robot has since driven over known ground for more than 10 places: it may be back.
  std::size_t leftBehind(const ViewLikeness& likeness) const;

  /// Sets the place of the last view, which may be the next new one. Adds the link from the place before.
  void arrive(std::uint32_t place);

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
  static Spread spreadOf(const ViewLikeness& likeness);
  bool atKnownPlace() const { return at_ && !at_new_; }  // at the last view
  bool excluded(std::uint32_t place) const;
  bool wayIsMeasured(std::uint32_t place) const;
  bool deadReckoningKnows(std::uint32_t place) const;
  std::optional<PlaceMass> onTheWay() const;
  double massOf(std::uint32_t place) const;
  double aheadOf(std::uint32_t place, const ViewLikeness& likeness) const;
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
  std::size_t candidates_ = 0;          // of the last view
  double novelty_ = 1.0;                // of the view since the last move
  bool measured_ = false;               // odometry has measured the last move
  // Buffers.
  std::vector<PlaceMass> added_;
  std::vector<PlaceAhead> around_;
};

}  // namespace ratslam
