#include "ratslam/odometry/odometry_doubts.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace ratslam {
namespace {

/// Ten seconds of odometry at 10 Hz in a curve, 1 m/s forward and `left` m/s to the left.
struct Drive {
  double left = 0.0;
  double forward = 1.0;
  double yaw_rate = 0.2;
  double twist_scale = 1.0;  ///< factor of linear.x
  double turn_scale = 1.0;   ///< factor of angular.z
  bool with_pose = true;
  bool with_twist = true;
};

std::vector<std::string> doubtsOf(const Drive& drive) {
  OdometryDoubts doubts;
  std::vector<std::string> all;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int k = 0; k < 100; ++k) {
    OdometrySample sample;
    sample.stamp = stampFromSeconds(0.1 * k);
    if (drive.with_twist) {
      sample.speed = drive.forward * drive.twist_scale;
      sample.sideways = drive.left * drive.twist_scale;
      sample.yaw_rate = drive.yaw_rate * drive.turn_scale;
    }
    if (drive.with_pose) sample.pose = pose;
    for (const std::string& doubt : doubts.add(sample)) all.push_back(doubt);
    pose = pose * Eigen::Translation3d(0.1 * drive.forward, 0.1 * drive.left, 0.0) *
           Eigen::AngleAxisd(0.1 * drive.yaw_rate, Eigen::Vector3d::UnitZ());
  }
  return all;
}

std::vector<std::string> doubtsOf(const std::function<void(Drive&)>& change) {
  Drive drive;
  change(drive);
  return doubtsOf(drive);
}

TEST(OdometryDoubts, GoodOdometryRaisesNone) {
  EXPECT_TRUE(doubtsOf(Drive{}).empty());
  EXPECT_TRUE(doubtsOf([](Drive& d) { d.with_pose = false; }).empty());
  EXPECT_TRUE(doubtsOf([](Drive& d) { d.with_twist = false; }).empty());
  EXPECT_TRUE(doubtsOf([](Drive& d) { d.forward = d.yaw_rate = 0.0; }).empty());
  EXPECT_TRUE(doubtsOf([](Drive& d) { d.twist_scale = 1.3; }).empty()) << "a wrong calibration is no unit";
  EXPECT_TRUE(doubtsOf([](Drive& d) { d.left = 0.1; }).empty()) << "slip";
  EXPECT_TRUE(doubtsOf([](Drive& d) { d.left = 0.015, d.forward = 0.0; }).empty()) << "noise at rest";
  EXPECT_TRUE(doubtsOf([](Drive& d) { d.forward = 0.0, d.yaw_rate = 1.0, d.left = 0.4; }).empty())
      << "turning on the spot, base_link before the axle";
}

TEST(OdometryDoubts, MotionToTheSideIsSaidOnceWithItsValue) {
  const auto twist = doubtsOf([](Drive& d) { d.left = -0.5, d.forward = 0.0; });
  ASSERT_EQ(twist.size(), 1U);
  EXPECT_EQ(twist[0].find("linear.y is not used, and it is -0.5 m/s at 0."), 0U) << twist[0];
  EXPECT_EQ(doubtsOf([](Drive& d) { d.left = 0.5, d.with_pose = false; }).size(), 1U);

  const auto pose = doubtsOf([](Drive& d) { d.left = 0.5, d.forward = 0.0, d.with_twist = false; });
  ASSERT_EQ(pose.size(), 1U);
  EXPECT_EQ(pose[0].find("the pose moves to the side"), 0U) << pose[0];
}

TEST(OdometryDoubts, ATwistInAnotherUnitThanThePoseIsSaidOnce) {
  const auto millimetres = doubtsOf([](Drive& d) { d.twist_scale = 1000.0; });
  ASSERT_EQ(millimetres.size(), 1U);
  EXPECT_NE(millimetres[0].find("is linear.x in m/s?"), std::string::npos) << millimetres[0];
  const auto degrees = doubtsOf([](Drive& d) { d.turn_scale = 57.3; });
  ASSERT_EQ(degrees.size(), 1U);
  EXPECT_NE(degrees[0].find("is angular.z in rad/s?"), std::string::npos) << degrees[0];
}

}  // namespace
}  // namespace ratslam
