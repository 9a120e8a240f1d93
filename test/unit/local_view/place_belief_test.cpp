/// The belief over places, fed with likenesses made by hand.
#include "ratslam/local_view/recall/place_belief.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr std::size_t kPlaces = 300;
constexpr double kStep = 0.1;  // [m]

/// Places learned along a street, one a step.
PlaceBelief streetOf(double novelty) {
  PlaceBelief belief;
  ViewMotion step;
  step.forward = kStep;
  for (std::uint32_t place = 0; place < kPlaces; ++place) {
    belief.move(step, novelty);
    belief.arrive(place);
  }
  belief.wakeUp();
  return belief;
}

/// Of a view that looks like all places within `width` steps of one, and like no other.
ViewLikeness alikeAround(std::size_t place, int width) {
  ViewLikeness likeness;
  likeness.variants = 1;
  likeness.places = kPlaces;
  likeness.priors = {1.0};
  for (std::size_t i = 0; i < kPlaces; ++i) {
    const int apart = std::abs(static_cast<int>(i) - static_cast<int>(place));
    likeness.values.push_back(apart <= width ? 1.0F : 0.01F * static_cast<float>(i % 7));
  }
  return likeness;
}

/// Confidence in the claim after a drive of `views` views along places that look alike within `width`.
double confidenceAfter(int views, int width, double novelty) {
  PlaceBelief belief = streetOf(novelty);
  ViewMotion step;
  step.forward = kStep;
  step.epoch = 1;  // woken up: dead reckoning knows nothing of the places
  std::optional<PlaceClaim> claim;
  for (int k = 0; k < views; ++k) {
    belief.move(step, novelty);
    claim = belief.weigh(alikeAround(100 + static_cast<std::size_t>(k), width), kPlaces);
  }
  return claim ? claim->confidence : 0.0;
}

/// In a dark tunnel a lit station is unlike all other places, by the root of their number.
TEST(PlaceBelief, KnowsTheOnePlaceThatIsUnlikeThousandsThatAreAlike) {
  constexpr std::size_t kMany = 4000;
  PlaceBelief belief;
  ViewMotion step;
  step.forward = kStep;
  for (std::uint32_t place = 0; place < kMany; ++place) {
    belief.move(step, 1.0);
    belief.arrive(place);
  }
  belief.wakeUp();
  ViewLikeness station;
  station.variants = 1;
  station.places = kMany;
  station.priors = {1.0};
  station.values.assign(kMany, 0.0F);
  station.values[1234] = 1.0F;
  step.epoch = 1;
  for (int k = 0; k < 3; ++k) {
    belief.move(step, 1.0);
    const auto claim = belief.weigh(station, kMany);
    ASSERT_TRUE(claim.has_value());
    EXPECT_TRUE(std::isfinite(claim->confidence)) << k;
    EXPECT_TRUE(std::isfinite(belief.unknown())) << k;
    if (k == 0) {
      EXPECT_EQ(claim->place, 1234U);
    }
    step.forward = 0.0;
  }
}

TEST(PlaceBelief, IsSureOfAPlaceThatStandsOut) {
  EXPECT_GT(confidenceAfter(20, 0, 0.5), PlaceBelief::kClaim);
}

/// Many views a metre: neighbours share the belief, and yet it is clear where the robot is.
TEST(PlaceBelief, IsSureAmongNeighboursThatItsViewsHardlyTellApart) {
  EXPECT_GT(confidenceAfter(60, 4, 0.15), PlaceBelief::kClaim);
}

/// The same spread over places whose views had little in common when they were learned says that it is not known
/// where the robot is.
TEST(PlaceBelief, IsNotSureAmongPlacesWhoseViewsDiffered) {
  EXPECT_LT(confidenceAfter(60, 8, 0.7), PlaceBelief::kClaim);
}

/// A street that is driven once, and the same views again round the corner, where dead reckoning cannot tell the places
/// apart any more but knows where the robot faces.
double confidenceRoundTheCorner(bool all_round) {
  PlaceBelief belief(all_round);
  ViewMotion step;
  step.forward = kStep;
  step.forward_variance = 1.0;
  step.yaw_variance = 1e-8;
  for (std::uint32_t place = 0; place < kPlaces; ++place) {
    belief.move(step, 0.5);
    belief.arrive(place);
  }
  step.rotation = M_PI / 2;
  std::optional<PlaceClaim> claim;
  for (int k = 0; k < 30; ++k) {
    belief.move(step, 0.5);
    claim = belief.weigh(alikeAround(100 + static_cast<std::size_t>(k), 0), kPlaces);
    step.rotation = 0.0;
  }
  return claim && claim->place > 100 && claim->place < 140 ? claim->confidence : 0.0;
}

TEST(PlaceBelief, AStreetThatLooksTheSameRoundTheCornerIsAnotherOne) {
  EXPECT_LT(confidenceRoundTheCorner(false), 0.01);
  EXPECT_GT(confidenceRoundTheCorner(true), 0.9) << "a panoramic view does not turn";
}

/// What is believed of the place after a stretch, once the robot has gone on from the place before it again and seen nothing.
/// @param left  the robot was carried away before that place
double beliefBeyond(double unmeasured, bool left = false) {
  constexpr std::uint32_t kStretch = 150;
  PlaceBelief belief;
  ViewMotion step;
  step.forward = kStep;
  for (std::uint32_t place = 0; place < kPlaces; ++place) {
    if (place == kStretch && (unmeasured > 0.0 || left)) ++step.epoch;
    if (place == kStretch && left) belief.wakeUp();
    step.unmeasured = place == kStretch ? unmeasured : 0.0;
    belief.move(step, 0.5);
    belief.arrive(place);
  }
  belief.wakeUp();
  step.epoch += 2;
  for (std::size_t k = 120; k <= kStretch; ++k) {
    belief.move(step, 0.5);
    if (k < kStretch) belief.weigh(alikeAround(k, 0), kPlaces);
  }
  const PlaceMass most = belief.strongest(1).front();
  return most.place == kStretch ? most.mass : 0.0;
}

TEST(PlaceBelief, NoWayLeadsAcrossAStretchThatNobodyMeasured) {
  EXPECT_GT(beliefBeyond(0.0), 0.7);
  EXPECT_LT(beliefBeyond(40.0), 0.1);
}

TEST(PlaceBelief, NoWayLeadsToWhereTheRobotWasCarried) { EXPECT_LT(beliefBeyond(0.0, true), 0.1); }

/// The odometry is silent while images come: what is seen leads on, though nobody says that the robot moves.
TEST(PlaceBelief, FollowsTheViewsAlongAStretchThatNobodyMeasures) {
  PlaceBelief belief = streetOf(0.5);
  ViewMotion step;
  step.forward = kStep;
  step.epoch = 1;
  std::size_t place = 100;
  const auto see = [&] {
    belief.move(step, 0.5);
    const std::optional<PlaceClaim> claim = belief.weigh(alikeAround(place, 1), kPlaces);
    const std::uint32_t at = claim ? claim->place : kPlaces;
    if (claim && claim->confidence > PlaceBelief::kClaim) belief.arrive(at);
    ++place;
    return at;
  };
  while (place < 120) see();
  step.forward = 0.0;
  step.unmeasured = 1.2 * kStep;
  step.epoch = 2;
  while (place < 150) {
    const std::uint32_t at = see();
    EXPECT_NEAR(at, static_cast<double>(place) - 1.0, 2.0) << place;
  }
}

/// Views of a loop that begins with a stretch learned twice: on the first lap, and at the end of it, before the robot knew
/// that it was back. Another lap later it must know that stretch, not learn it once more, and once more with each lap.
TEST(PlaceBelief, PlacesThatWereLeftALapAgoMayBeWhereTheRobotIs) {
  PlaceBelief belief;
  ViewMotion step;
  step.forward = kStep;
  for (std::uint32_t place = 0; place < kPlaces; ++place) {  // the last 20 lie where the first 20 do
    belief.move(step, 0.5);
    belief.arrive(place);
  }
  EXPECT_EQ(belief.leftBehind(alikeAround(kPlaces - 1, 15)), kPlaces - 16);
  for (std::uint32_t place = 20; place < kPlaces - 20; ++place) {
    belief.move(step, 0.5);
    EXPECT_LT(belief.leftBehind(alikeAround(kPlaces - 1, 15)), place < 28 ? kPlaces - 9 : kPlaces + 1)
        << place;
    belief.arrive(place);
  }
  EXPECT_EQ(belief.leftBehind(alikeAround(kPlaces - 20, 1)), kPlaces);
}

/// A robot that may not learn drives on beyond the last place, and is found again at the first one. The last one is known
/// again a lap later: the way to the first is no neighbourhood in which likeness tells how far ahead the robot is.
TEST(PlaceBelief, AWayThatIsNotLearnedJoinsNoPlaces) {
  // Size of the saved belief, which grows with a link.
  const auto size = [](std::uint32_t arrives_at, bool learns) {
    PlaceBelief belief;
    ViewMotion step;
    step.forward = kStep;
    for (std::uint32_t place = 0; place < kPlaces; ++place) {
      belief.move(step, 0.5);
      belief.arrive(place);
    }
    for (int k = 0; k < 13; ++k) belief.move(step, 0.5);
    belief.arrive(arrives_at, learns);
    State state;
    state.set("belief", belief);
    return state.toBytes().size();
  };
  EXPECT_GT(size(0, true), size(0, false));
  EXPECT_EQ(size(kPlaces - 1, true), size(0, false)) << "as if it had not left";
}

/// The claim at the twelfth of twenty places of a loop that were learned twice, on ways that part before them.
/// @param last  how like the last view is to the later one of two twins; all others are as like as can be
PlaceClaim claimAmongTwins(bool said, float last = 1.0F) {
  constexpr std::uint32_t kTwins = 20;
  PlaceBelief belief;
  ViewMotion step;
  step.forward = kStep;
  step.rotation = 2.0 * M_PI / static_cast<double>(kPlaces - kTwins);
  if (said) step.forward_variance = step.yaw_variance = 1e-6;
  const auto drive = [&](std::uint32_t from, std::uint32_t to) {
    for (std::uint32_t place = from; place < to; ++place) {
      belief.move(step, 0.5);
      belief.arrive(place);
    }
  };
  drive(0, kPlaces - kTwins);
  drive(0, kPlaces);  // the last ones new, where the first ones lie
  const auto view = [last](std::size_t place) {
    ViewLikeness likeness = alikeAround(place, 0);
    if (place < kTwins) likeness.values[kPlaces - kTwins + place] = place == 11 ? last : 1.0F;
    return likeness;
  };
  std::optional<PlaceClaim> claim;
  for (std::uint32_t place = kTwins; place < kPlaces - kTwins + 12; ++place) {
    belief.move(step, 0.5);
    claim = belief.weigh(view(place % (kPlaces - kTwins)), kPlaces);
    belief.arrive(claim && place > kPlaces - kTwins ? claim->place : place);
  }
  return claim.value_or(PlaceClaim{});
}

TEST(PlaceBelief, TwinsOfOneStretchOfRoadAreOnePlaceForWhoKnowsItsWay) {
  EXPECT_GT(claimAmongTwins(true).confidence, PlaceBelief::kClaim);
  EXPECT_LT(claimAmongTwins(false).confidence, PlaceBelief::kClaim);
}

/// Else the place would be learned anew, and again whenever the robot comes by.
TEST(PlaceBelief, WhoKnowsItsWayStaysOnItThoughATwinIsLikerNow) {
  const std::uint32_t on_the_way = claimAmongTwins(true).place;
  for (const float last : {1.0F, 0.9F}) {
    const PlaceClaim claim = claimAmongTwins(true, last);
    EXPECT_GT(claim.confidence, PlaceBelief::kClaim) << last;
    EXPECT_EQ(claim.place, on_the_way) << last;
  }
}

/// Number of views until a robot that woke up at a place of the street claims it; none within ten.
std::optional<int> viewsUntilFound(std::size_t place) {
  PlaceBelief belief = streetOf(1.0);
  ViewMotion step;
  step.forward = kStep;
  step.epoch = 1;
  for (int k = 0; k < 10; ++k) {
    belief.move(step, 1.0);
    const ViewLikeness likeness = alikeAround(std::min(place + static_cast<std::size_t>(k), kPlaces - 1), 0);
    const auto claim = belief.weigh(likeness, belief.leftBehind(likeness));
    if (claim && claim->confidence > PlaceBelief::kClaim) return k + 1;
  }
  return std::nullopt;
}

TEST(PlaceBelief, WakesUpWhereItsLastDriveEndedAsSoonAsElsewhere) {
  const std::optional<int> elsewhere = viewsUntilFound(100);
  ASSERT_TRUE(elsewhere);
  for (const std::size_t place : {kPlaces - 30, kPlaces - 12, kPlaces - 9, kPlaces - 4}) {
    EXPECT_EQ(viewsUntilFound(place), elsewhere) << "place " << place;
  }
}

}  // namespace
}  // namespace ratslam
