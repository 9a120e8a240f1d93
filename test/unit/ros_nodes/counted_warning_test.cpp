#include "ratslam_ros/support/counted_warning.h"

#include <gtest/gtest.h>

namespace ratslam {
namespace {

TEST(CountedWarning, CountsWhatHappensAndNotWhatALoadedStateBrings) {
  CountedWarning warning;
  warning.reportIncrease("it happened", 7, 7);  // another part's, loaded
  EXPECT_EQ(warning.count(), 0U);
  warning.reportIncrease("it happened", 7, 9);
  EXPECT_EQ(warning.count(), 2U);
  warning.reportIncrease("it happened", 0, 1);  // after a reset
  EXPECT_EQ(warning.count(), 3U);
  warning.reportIncrease("it happened", 3, 0);
  EXPECT_EQ(warning.count(), 3U);
}

}  // namespace
}  // namespace ratslam
