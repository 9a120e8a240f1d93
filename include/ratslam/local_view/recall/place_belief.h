/// Where among the learned places the robot may be: a belief that odometry moves along the ways driven and
/// each view weighs. One of the possibilities is a place that is not yet known.
///
/// For each view:
///   1. Move (move). A place stands for the stretch of way from where it was learned to where the next one was: the
///      robot may be anywhere on it. Its belief goes on along its links by the way driven since the last view. That way
///      may be longer or shorter than the one driven then by 0.4 of itself, or by more if the odometry says so. On a
///      chain with one step a place, 0.1 of the belief stays, 0.8 goes to the next place and 0.1 to the one after it.
///      Belief that would leave the links goes to the place not yet known, and so does a two-thousandth of all other
///      belief (less where the view has not changed). Places learned just now lead nowhere: whoever is there is at a
///      place not yet known.
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
///      counts for more, by n (z - 6)^2, so that a recall comes soon; if it does, there is time to wait until the place
///      is seen from where it was learned.
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
  /// Variances of the two [m^2, rad^2], where the odometry says.
  std::optional<double> forward_variance;
  std::optional<double> yaw_variance;
  std::uint32_t epoch = 0;  ///< changes when dead reckoning is broken
  /// How far it may have gone where nobody measured (standard deviation) [m]: no way is known to lead on from before. An
  /// odometry that knows by itself how well it has predicted a stretch measures.
  double unmeasured = 0.0;
  /// Not measured: each view counts as one step on, and dead reckoning excludes nothing.
  bool assumed = false;

  static ViewMotion oneStep() {
    ViewMotion motion;
    motion.forward = 1.0;
    motion.assumed = true;
    return motion;
  }
};

/// The place most believed in.
struct PlaceClaim {
  std::uint32_t place = 0;
  double confidence = 0.0;  ///< belief at it, within 2 links of it, and at what is hardly told apart from it
  /// How far ahead of the place, on the way that was driven then, by the views learned before and after it [m]; 0 where
  /// they do not tell, the motion is not measured, or the confidence is not above kClaim.
  double ahead = 0.0;
  /// Of each variant of the view, how like the place it looks against the others; they sum to 1.
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
  /// Belief in one claimed place above which it counts as recalled.
  static constexpr double kClaim = 0.99;

  PlaceBelief() = default;
  /// @param all_round the views look the same whichever way the robot faces
  explicit PlaceBelief(bool all_round) : all_round_(all_round) {}

  /// The robot has moved since the last view. @param novelty of the view that is to be weighed next, 0 to 1:
  /// how much of it the last view did not tell (ViewMatcher::novelty)
  void move(const ViewMotion& motion, double novelty);

  /// Steps 2 to 4. @param candidates places of lower number than this may be where the robot is.
  /// @return the place most believed in; none where all belief is in places not yet known.
  std::optional<PlaceClaim> weigh(const ViewLikeness& likeness, std::size_t candidates);

  /// Candidates of a view while the robot maps: all but the last 10 learned and, from there back, all that
  /// still look like the view: the robot has just left them. Not those after which it has driven over known ground for
  /// longer than 10 places take: it may be back.
  std::size_t leftBehind(const ViewLikeness& likeness) const;

  /// The robot is at this place, which may be the next new one; the way from the place before is remembered.
  void arrive(std::uint32_t place);

  /// The robot starts anew, most likely somewhere among the learned places, nobody knows where.
  void wakeUp();

  /// The `count` places most believed in, most first.
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
  /// Of the likeness of all places.
  struct Spread {
    double mean = 0.0;
    double deviation = 1.0;

    double standardised(float value) const { return (static_cast<double>(value) - mean) / deviation; }
  };
  static Spread spreadOf(const ViewLikeness& likeness);
  bool atKnownPlace() const { return at_ && !at_new_; }  // when it saw the last view
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
  std::vector<PlaceMass> active_;  // by place
  double unknown_ = 1.0;
  std::vector<double> variants_;  // belief in each
  DeadReckoning here_;
  std::optional<std::uint32_t> at_;  // place of the last view
  bool at_new_ = false;              // which that view was the first of
  double step_ = 0.0;                // of the last move [m]
  double since_arrival_ = 0.0;       // way driven since [m]
  double novelty_since_arrival_ = 0.0;
  bool waking_ = false;         // no view since wakeUp()
  std::size_t candidates_ = 0;  // of the last view
  double novelty_ = 1.0;        // of the view since the last move
  bool measured_ = false;       // the motion, by odometry
  // Buffers.
  std::vector<PlaceMass> added_;
  std::vector<PlaceAhead> around_;
};

}  // namespace ratslam
