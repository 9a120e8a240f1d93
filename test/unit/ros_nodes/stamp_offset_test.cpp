#include "ratslam_ros/support/stamp_offset.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace ratslam {
namespace {

constexpr Stamp kSecond = 1'000'000'000;

/// A camera that is slow or has stopped has no other clock.
TEST(StampOffset, IsThatOfTheClocksHoweverLongOneStreamHasWaited) {
  StampOffset offset;
  EXPECT_FALSE(offset.secondAlone());
  offset.first(100 * kSecond);
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  offset.second(100 * kSecond + 2 * kSecond / 5);
  EXPECT_NEAR(offset.seconds().value(), 0.0, 0.2);
  EXPECT_GE(offset.secondAlone().value(), 0.4);
  offset.first(103 * kSecond);
  EXPECT_NEAR(offset.seconds().value(), -2.6, 0.2);
  EXPECT_EQ(offset.secondAlone().value(), 0.0);
}

}  // namespace
}  // namespace ratslam
