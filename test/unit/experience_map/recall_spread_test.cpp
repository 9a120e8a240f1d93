#include "ratslam/experience_map/solver/recall_spread.h"

#include <gtest/gtest.h>

namespace ratslam {
namespace {

/// Squares of ways of no length vanish, and what is divided by them is no number.
TEST(RecallSpread, WhoStandsStillTellsNothingOfHowFarAPlaceReaches) {
  RecallSpread spread(0.0, 0.3);
  for (int k = 0; k < 3; ++k) spread.addSpacing(0.6);
  const double place = spread.place();
  EXPECT_NEAR(place, 0.8, 1e-12);
  for (int k = 0; k < 50; ++k) spread.addSpacing(1e-160);
  EXPECT_EQ(spread.place(), place);
}

}  // namespace
}  // namespace ratslam
