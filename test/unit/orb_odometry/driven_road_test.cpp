/// The camera's height above patches of road that it passes over.
#include "ratslam/odometry/orb/driven_road.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ratslam/common/angles.h"

namespace ratslam {
namespace {

constexpr double kHeight = 1.65;
constexpr double kBegin = 5.0;                                                 // of the slope [m]
const double kSlope = degreesToRadians(3.0);                                   // upwards
const RigidTransform kStep{Eigen::Quaterniond::Identity(), {0.0, 0.0, -0.5}};  // the road comes nearer

/// The flat road as it is seen from above it, with a patch at (x, z).
RoadMeasurement flatRoad(double x, double z) {
  RoadMeasurement road;
  road.plane = {Eigen::Vector3d::UnitY(), kHeight};
  road.centre = {x, kHeight, z};
  road.sigma_centre = 0.004;
  return road;
}

std::vector<DrivenHeight> drive(DrivenRoad& driven, int steps, const RigidTransform& step = kStep) {
  std::vector<DrivenHeight> heights;
  for (int i = 0; i < steps; ++i) {
    for (const DrivenHeight& height : driven.moveOn(step, kHeight)) heights.push_back(height);
  }
  return heights;
}

TEST(DrivenRoad, TellsTheHeightOnceThePatchIsReached) {
  DrivenRoad driven;
  driven.moveOn(kStep, kHeight);
  EXPECT_FALSE(driven.add(flatRoad(0.0, 7.7)));
  EXPECT_TRUE(drive(driven, 15).empty());
  const auto heights = drive(driven, 30);
  ASSERT_EQ(heights.size(), 1U);
  EXPECT_NEAR(heights[0].height, kHeight, 1e-12);
  EXPECT_NEAR(heights[0].sigma_log, 0.004, 1e-12);
}

/// Pose of a camera that keeps its height above a road that begins to rise, without pitching.
RigidTransform aboveTheSlope(double way) {
  if (way < kBegin) return {Eigen::Quaterniond::Identity(), {0.0, 0.0, way}};
  const double on = way - kBegin;
  const Eigen::Vector3d up(0.0, -std::cos(kSlope), -std::sin(kSlope));
  const Eigen::Vector3d ground(0.0, kHeight - on * std::sin(kSlope), kBegin + on * std::cos(kSlope));
  return {Eigen::Quaterniond::Identity(), ground + kHeight * up};
}

TEST(DrivenRoad, ASlopeAheadDoesNotChangeTheHeight) {
  DrivenRoad driven;
  // From the flat road the patch is seen where the road already rises.
  RoadMeasurement road;
  road.plane.normal = {0.0, std::cos(kSlope), std::sin(kSlope)};
  road.centre = {0.0, kHeight - 4.0 * std::sin(kSlope), kBegin + 4.0 * std::cos(kSlope)};
  road.plane.height = road.plane.normal.dot(road.centre);
  EXPECT_GT(std::abs(std::log(road.plane.height / kHeight)),
            0.1);  // the plane continued to the camera is wrong
  driven.add(road);
  std::vector<DrivenHeight> heights;
  for (double way = 0.5; way < 12.0; way += 0.5) {
    const RigidTransform T_now_before = aboveTheSlope(way).inverse() * aboveTheSlope(way - 0.5);
    for (const DrivenHeight& height : driven.moveOn(T_now_before, kHeight)) heights.push_back(height);
  }
  ASSERT_EQ(heights.size(), 1U);
  EXPECT_NEAR(heights[0].height, kHeight, 0.005 * kHeight);
}

TEST(DrivenRoad, BackwardsThePatchHasBeenPassedBefore) {
  DrivenRoad driven;
  const RigidTransform back = kStep.inverse();
  EXPECT_TRUE(drive(driven, 20, back).empty());
  const auto height = driven.add(flatRoad(0.1, 6.0));
  ASSERT_TRUE(height);
  EXPECT_NEAR(height->height, kHeight, 1e-12);
  EXPECT_TRUE(drive(driven, 40).empty());  // it is used once, though the car comes there again
}

TEST(DrivenRoad, APatchBesideTheWayIsNotUsedAndOneNearItLessCertain) {
  DrivenRoad driven;
  driven.add(flatRoad(1.2 * kHeight, 6.0));
  driven.moveOn(kStep, kHeight);
  driven.add(flatRoad(kHeight, 6.2));
  const auto heights = drive(driven, 30);
  ASSERT_EQ(heights.size(), 1U);
  EXPECT_NEAR(heights[0].sigma_log, std::hypot(0.004, std::tan(degreesToRadians(0.7))), 1e-4);
}

TEST(DrivenRoad, ANewUnitConvertsWhatIsWaiting) {
  DrivenRoad driven;
  driven.add(flatRoad(0.0, 6.0));
  drive(driven, 5);
  driven.rescale(2.0);
  const auto heights = drive(driven, 10, {Eigen::Quaterniond::Identity(), {0.0, 0.0, -1.0}});
  ASSERT_EQ(heights.size(), 1U);
  EXPECT_NEAR(heights[0].height, 2.0 * kHeight, 1e-12);
  // The way so far is converted, too: backwards a patch lies where the camera has been.
  DrivenRoad back;
  drive(back, 20, kStep.inverse());
  back.rescale(2.0);
  RoadMeasurement road = flatRoad(0.0, 18.0);  // within the 20 m of the new unit
  road.plane.height *= 2.0;
  road.centre.y() *= 2.0;
  const auto height = back.add(road);
  ASSERT_TRUE(height);
  EXPECT_NEAR(height->height, 2.0 * kHeight, 1e-12);
}

TEST(DrivenRoad, PatchesThatAreNeverReachedAreForgotten) {
  DrivenRoad driven;
  driven.add(flatRoad(0.0, 6.0));
  drive(driven, 40, {Eigen::Quaterniond::Identity(), {0.5, 0.0, 0.0}});  // away to the side, and back again
  drive(driven, 40, {Eigen::Quaterniond::Identity(), {-0.5, 0.0, 0.0}});
  EXPECT_TRUE(drive(driven, 100).empty());
}

TEST(DrivenRoad, ShortStepsLoseNoPatch) {
  DrivenRoad driven;
  const RigidTransform creep{Eigen::Quaterniond::Identity(), {0.0, 0.0, -0.02}};
  std::vector<DrivenHeight> heights;
  for (int i = 0; i < 2000; ++i) {
    for (const DrivenHeight& height : driven.moveOn(creep, kHeight)) heights.push_back(height);
    driven.add(flatRoad(0.0, 8.0));
  }
  EXPECT_GT(heights.size(), 80U);  // of a patch each third of a metre over 32 m
  EXPECT_LT(heights.size(), 110U);
  for (const DrivenHeight& height : heights) EXPECT_NEAR(height.height, kHeight, 1e-9);
}

TEST(DrivenRoad, AJumpIsNoWayThatWasDriven) {
  DrivenRoad driven;
  driven.add(flatRoad(0.0, 6.0));
  EXPECT_TRUE(drive(driven, 1, {Eigen::Quaterniond::Identity(), {0.0, 0.0, -9.0}}).empty());
  EXPECT_TRUE(drive(driven, 30).empty());
}

TEST(DrivenRoad, StandingStillTellsNothing) {
  DrivenRoad driven;
  driven.add(flatRoad(0.0, 0.0));
  EXPECT_TRUE(drive(driven, 10, RigidTransform{}).empty());
}

}  // namespace
}  // namespace ratslam
