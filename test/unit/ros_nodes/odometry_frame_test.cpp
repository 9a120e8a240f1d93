#include "ratslam_ros/support/odometry_frame.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ratslam {
namespace {

OdometrySample posed(Stamp stamp, double x, double yaw) {
  OdometrySample sample;
  sample.stamp = stamp;
  sample.pose =
      Eigen::Translation3d(x, 0.0, 0.0) * Eigen::Isometry3d(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
  return sample;
}

TEST(OdometryFrame, KnowsNothingOutsideItsSamples) {
  OdometryFrame frame;
  EXPECT_FALSE(frame.poseAt(5));
  frame.add(posed(10, 0.0, 0.0));
  frame.add(posed(20, 1.0, 0.0));
  EXPECT_FALSE(frame.poseAt(9));
  EXPECT_FALSE(frame.poseAt(21));
  EXPECT_TRUE(frame.poseAt(20));
}

TEST(OdometryFrame, DividesBetweenSamplesInProportionToTime) {
  OdometryFrame frame;
  frame.add(posed(1000000000, 0.0, 3.0));
  frame.add(posed(2000000000, 4.0, -3.0));
  const auto pose = frame.poseAt(1250000000);
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->x, 1.0, 1e-12);
  EXPECT_NEAR(pose->yaw, 3.0 + 0.25 * (2.0 * kPi - 6.0), 1e-12);
}

TEST(OdometryFrame, AddsUpTwistsWhereThereIsNoPose) {
  OdometryFrame frame;
  for (int i = 0; i <= 10; ++i) {
    OdometrySample sample;
    sample.stamp = Stamp{100000000} * i;
    sample.speed = 2.0;
    frame.add(sample);
  }
  const auto pose = frame.poseAt(1000000000);
  ASSERT_TRUE(pose);
  EXPECT_NEAR(pose->x, 2.0, 1e-9);
}

TEST(OdometryFrame, StartsAnewWhenTimeGoesBack) {
  OdometryFrame frame;
  frame.add(posed(10, 0.0, 0.0));
  frame.add(posed(20, 1.0, 0.0));
  frame.add(posed(5, 7.0, 0.0));
  EXPECT_FALSE(frame.poseAt(20));
  ASSERT_TRUE(frame.poseAt(5));
  EXPECT_EQ(frame.poseAt(5)->x, 7.0);
}

TEST(OdometryFrame, ForgetsTheOldestOfVeryManyThatNobodyAsksAbout) {
  OdometryFrame frame;
  const int count = 300000;
  for (int i = 0; i < count; ++i) frame.add(posed(i, 0.001 * i, 0.0));
  EXPECT_FALSE(frame.poseAt(count / 2));
  ASSERT_TRUE(frame.poseAt(count - 10));
  EXPECT_NEAR(frame.poseAt(count - 1)->x, 0.001 * (count - 1), 1e-9);
}

TEST(MapToOdom, LeadsFromTheOdometrysPoseToTheMaps) {
  const MapPose in_map{10.0, -3.0, 1.0, 2.5};
  const RelativePose in_odom{4.0, 5.0, 0.2, -1.0};
  const Eigen::Isometry3d transform = mapToOdom(in_map, in_odom);
  const Eigen::Vector3d place = transform * Eigen::Vector3d(in_odom.x, in_odom.y, in_odom.z);
  EXPECT_NEAR((place - Eigen::Vector3d(in_map.x, in_map.y, in_map.z)).norm(), 0.0, 1e-12);
  const Eigen::Vector3d ahead =
      transform.linear() * Eigen::Vector3d(std::cos(in_odom.yaw), std::sin(in_odom.yaw), 0.0);
  EXPECT_NEAR(std::atan2(ahead.y(), ahead.x()), in_map.yaw, 1e-12);
}

}  // namespace
}  // namespace ratslam
