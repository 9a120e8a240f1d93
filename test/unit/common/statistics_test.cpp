#include "ratslam/common/statistics.h"

#include <gtest/gtest.h>

namespace ratslam {
namespace {

TEST(Statistics, TheMedianIsTheMiddleOneWhateverTheOthersAre) {
  EXPECT_EQ(median({3.0, -1e9, 5.0}), 3.0);
  EXPECT_EQ(median({7.0}), 7.0);
  EXPECT_EQ(median({4.0, 1.0, 3.0, 2.0}), 3.0);
}

TEST(Statistics, DeviationsAreCountedToBothSides) {
  EXPECT_EQ(medianDeviation({-2.0, 1.0, 9.0}, 0.0), 2.0);
  EXPECT_EQ(medianDeviation({8.0, 9.0, 10.0, 11.0, 100.0}, 10.0), 1.0);
}

}  // namespace
}  // namespace ratslam
