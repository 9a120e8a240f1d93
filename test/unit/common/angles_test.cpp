#include "ratslam/common/angles.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ratslam/common/pose2.h"

namespace ratslam {
namespace {

TEST(WrapAngle, KeepsTheDirectionAndTheHalfOpenRange) {
  for (double angle = -30.0; angle < 30.0; angle += 0.37) {
    const double wrapped = wrapAngle(angle);
    EXPECT_GT(wrapped, -kPi);
    EXPECT_LE(wrapped, kPi);
    EXPECT_NEAR(std::cos(wrapped), std::cos(angle), 1e-12);
    EXPECT_NEAR(std::sin(wrapped), std::sin(angle), 1e-12);
  }
  EXPECT_DOUBLE_EQ(wrapAngle(-kPi), kPi);
  EXPECT_DOUBLE_EQ(wrapAngle(kPi), kPi);
}

TEST(WrapAngle, GivesTheBitsOfTheExactRemainder) {
  const auto expect_remainder = [](double angle) {
    const double remainder = std::remainder(angle, 2.0 * kPi);
    EXPECT_EQ(wrapAngle(angle), remainder <= -kPi ? remainder + 2.0 * kPi : remainder) << angle;
  };
  for (double angle = -30.0; angle < 30.0; angle += 0.0137) expect_remainder(angle);
  for (const double edge : {kPi, 3.0 * kPi, 9.0, 5.0 * kPi}) {
    for (const double sign : {1.0, -1.0}) {
      expect_remainder(sign * edge);
      expect_remainder(sign * std::nextafter(edge, 0.0));
      expect_remainder(sign * std::nextafter(edge, 100.0));
    }
  }
}

TEST(Pose2, BetweenUndoesCompose) {
  const Pose2 a{1.0, -2.0, 2.5};
  const Pose2 b{-0.3, 4.0, -3.0};
  const Pose2 back = between(a, compose(a, b));
  EXPECT_NEAR(back.x, b.x, 1e-12);
  EXPECT_NEAR(back.y, b.y, 1e-12);
  EXPECT_NEAR(back.th, b.th, 1e-12);
}

}  // namespace
}  // namespace ratslam
