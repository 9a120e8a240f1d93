/// The filter of the odometry's unit of length: outliers, changes, what it says about its own error.
#include "ratslam/odometry/orb/unit_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ratslam {
namespace {

constexpr double kHeight = 1.65;
constexpr double kSigma = 0.01;
constexpr double kStep = 0.5;  // between measurements [m]

/// A unit whose log is off by `error`, and a filter that corrects it.
class UnitFilterOnARoad : public ::testing::Test {
 protected:
  UnitFilterOnARoad() { filter_.start(kHeight); }
  void measure(double noise = 0.0) {
    filter_.move(kStep);
    error_ -= filter_.use(error_ + noise, kSigma * kSigma);
  }
  void drive(double way, double noise = 0.0) {
    for (double driven = 0.0; driven < way; driven += kStep) measure(noise);
  }
  UnitFilter filter_;
  double error_ = 0.0;
};

TEST_F(UnitFilterOnARoad, BeginsWithTheMedianOfTheFirstMeasurements) {
  error_ = 0.08;
  measure(0.15);  // a kerb
  for (int i = 0; i < 3; ++i) measure();
  EXPECT_EQ(error_, 0.08);
  EXPECT_TRUE(filter_.starting());
  EXPECT_NEAR(filter_.sigma(), UnitFilterParams{}.start_sigma, 0.01);
  measure();
  EXPECT_FALSE(filter_.starting());
  EXPECT_NEAR(error_, 0.0, 1e-12);
}

TEST_F(UnitFilterOnARoad, LeavesOutASingleOutlierAndAShortStretchOfThem) {
  drive(50.0);
  drive(10.0, 0.2);  // less than two pieces of road
  EXPECT_NEAR(error_, 0.0, 1e-6);
  drive(50.0);
  EXPECT_NEAR(error_, 0.0, 1e-6);
  EXPECT_FALSE(filter_.lost());
}

TEST_F(UnitFilterOnARoad, FindsBackWhenTheUnitItselfHasChanged) {
  drive(50.0);
  error_ = 0.2;  // a sharp turn with few landmarks
  drive(2.0 * 4.0 * kHeight - 2.0 * kStep);
  EXPECT_NEAR(error_, 0.2, 0.01);  // it may be the road still
  drive(6.0);
  EXPECT_NEAR(error_, 0.0, 1e-6);
  EXPECT_FALSE(filter_.lost());
}

TEST_F(UnitFilterOnARoad, AfterALongWayWithoutARoadAFewThatAgreeAreEnough) {
  drive(50.0);
  error_ = 0.2;
  filter_.move(20.0);
  drive(3.0);
  EXPECT_NEAR(error_, 0.2, 1e-12);
  drive(2.0);
  EXPECT_NEAR(error_, 0.0, 0.01);
}

TEST_F(UnitFilterOnARoad, OneWildOutlierAmongThoseThatAgreeIsNotAdopted) {
  drive(50.0);
  error_ = 0.1;
  drive(2.0 * 4.0 * kHeight - 2.0 * kStep);
  measure(0.4);
  drive(3.0);
  EXPECT_NEAR(error_, 0.0, 0.01);
}

TEST_F(UnitFilterOnARoad, IsLostIfAllContradictEachOtherForLong) {
  drive(50.0);
  for (int i = 0; i < 200 && !filter_.lost(); ++i) measure(i % 2 == 0 ? 0.3 : -0.3);
  EXPECT_TRUE(filter_.lost());
  EXPECT_NEAR(error_, 0.0, 1e-6);
  filter_.start(kHeight);
  EXPECT_FALSE(filter_.lost());
}

TEST_F(UnitFilterOnARoad, ManyPatchesOfOnePieceOfRoadTellNoMoreThanOne) {
  drive(50.0);
  UnitFilter dense = filter_;
  filter_.move(4.0);
  const double once = filter_.use(0.02, kSigma * kSigma);
  double sum = 0.0;
  for (int i = 0; i < 400; ++i) {
    dense.move(0.01);
    sum += dense.use(0.02 - sum, kSigma * kSigma);
  }
  EXPECT_LT(sum, 1.1 * once);
  EXPECT_GT(sum, 0.3 * once);
}

TEST_F(UnitFilterOnARoad, IsAsUncertainAsItsErrorsAre) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const double walk = std::sqrt(filter_.walkVariance() * kStep);
  drive(10.0);
  double squares = 0.0;
  double variances = 0.0;
  double bump = 0.0;
  for (int i = 0; i < 20000; ++i) {
    error_ += walk * normal(random);
    // What is wrong with a piece of road changes within some 4 heights.
    bump += kStep / (2.0 * kHeight) * -bump + std::sqrt(kStep / kHeight) * kSigma * normal(random);
    measure(bump);
    squares += error_ * error_;
    variances += filter_.sigma() * filter_.sigma();
  }
  EXPECT_GT(squares, 0.3 * variances);
  EXPECT_LT(squares, 3.0 * variances);
}

TEST_F(UnitFilterOnARoad, WithoutARoadTheUnitWalks) {
  drive(100.0);
  const double before = filter_.sigma();
  filter_.move(100.0);
  EXPECT_NEAR(filter_.sigma(), std::hypot(before, std::sqrt(100.0 * filter_.walkVariance())), 1e-12);
}

TEST_F(UnitFilterOnARoad, TheFirstCorrectionIsNoWalk) {
  const double before = filter_.walkVariance();
  error_ = 0.09;
  drive(60.0);
  EXPECT_LE(filter_.walkVariance(), before);
}

}  // namespace
}  // namespace ratslam
