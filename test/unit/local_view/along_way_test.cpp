#include "ratslam/local_view/recall/along_way.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ratslam/local_view/recall/place_belief.h"

namespace ratslam {
namespace {

/// How like a view from `here` is to one learned at `there`, where views change evenly.
double evenly(double here, double there) { return 0.8 - 0.3 * std::abs(here - there); }

double peakSeenFrom(double here, double before, double after) {
  return likestBetween({before, evenly(here, before)}, evenly(here, 0.0), {after, evenly(here, after)}, -1.0);
}

TEST(AlongWay, FindsWhereTheViewIsBetweenThreePlaces) {
  for (const double here : {-0.4, -0.1, 0.0, 0.25, 0.49}) {
    EXPECT_NEAR(peakSeenFrom(here, -1.0, 1.0), here, 1e-12) << here;
  }
}

TEST(AlongWay, PlacesNeedNotBeEquallyFarApart) {
  for (const double here : {-0.6, -0.2, 0.1, 0.2})
    EXPECT_NEAR(peakSeenFrom(here, -1.3, 0.5), here, 1e-12) << here;
}

TEST(AlongWay, GoesAtMostHalfTheWayToTheNext) {
  EXPECT_EQ(peakSeenFrom(0.9, -1.0, 1.0), 0.5);
  EXPECT_EQ(peakSeenFrom(-2.0, -0.6, 1.0), -0.3);
}

TEST(AlongWay, SaysNothingWhereTheMiddleIsTheLeastAlikeOrThePlacesDoNotFollowEachOther) {
  EXPECT_EQ(likestBetween({-1.0, 0.5}, 0.4, {1.0, 0.6}, 0.1), 0.0);
  EXPECT_EQ(likestBetween({-1.0, 0.5}, 0.5, {1.0, 0.5}, 0.1), 0.0);
  EXPECT_EQ(likestBetween({0.0, 0.2}, 0.5, {1.0, 0.4}, 0.1), 0.0);
  EXPECT_EQ(likestBetween({-1.0, 0.2}, 0.5, {0.0, 0.4}, 0.1), 0.0);
}

/// The next place lies beyond a stretch on which nothing was learned, as in the dark.
TEST(AlongWay, APlaceBeyondAGapTellsNothing) {
  EXPECT_EQ(likestBetween({-1.0, 0.5}, 0.8, {13.0, 0.15}, 0.1), 0.0);
  EXPECT_EQ(likestBetween({-13.0, 0.15}, 0.8, {1.0, 0.5}, 0.1), 0.0);
  EXPECT_NEAR(likestBetween({-1.0, 0.4}, 0.8, {1.5, 0.35}, 0.1), 0.1875, 1e-12);
}

constexpr std::size_t kPlaces = 60;

/// A second drive along a street of places 1 m apart, each view taken 0.3 m behind where the first one was; the last of
/// them is seen from `here` metres beyond the place.
PlaceClaim secondDrive(const ViewMotion& step, double here) {
  PlaceBelief belief;
  for (std::uint32_t place = 0; place < kPlaces; ++place) {
    belief.move(step, 1.0);
    belief.arrive(place);
  }
  belief.wakeUp();
  ViewMotion again = step;
  again.epoch = 1;
  std::optional<PlaceClaim> claim;
  for (int k = 20; k < 40; ++k) {
    ViewLikeness likeness;
    likeness.variants = 1;
    likeness.places = kPlaces;
    likeness.priors = {1.0};
    const double seen_from = k + (k == 39 ? here : -0.3);
    for (std::size_t i = 0; i < kPlaces; ++i) {
      const double apart = std::abs(static_cast<double>(i) - seen_from);
      likeness.values.push_back(
          static_cast<float>(std::max(0.8 - 0.3 * apart, 0.01 * static_cast<double>(i % 7))));
    }
    belief.move(again, 1.0);
    claim = belief.weigh(likeness, kPlaces);
  }
  return claim.value_or(PlaceClaim{});
}

TEST(PlaceBelief, SaysHowFarAheadOfAPlaceTheRobotIs) {
  ViewMotion step;
  step.forward = 1.0;
  for (const double here : {-0.3, 0.2}) {
    const PlaceClaim claim = secondDrive(step, here);
    ASSERT_GT(claim.confidence, PlaceBelief::kClaim);
    EXPECT_NEAR(claim.place + claim.ahead, 39.0 + here, 1e-6) << here;
  }
}

TEST(PlaceBelief, SaysNoDistanceWhereNobodyMeasuresTheWay) {
  const PlaceClaim claim = secondDrive(ViewMotion::oneStep(), 0.2);
  ASSERT_GT(claim.confidence, PlaceBelief::kClaim);
  EXPECT_EQ(claim.ahead, 0.0);
}

}  // namespace
}  // namespace ratslam
