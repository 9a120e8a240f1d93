#include "ratslam_ros/support/conversions.h"

#include <gtest/gtest.h>

#include <limits>

#include "ratslam/common/angles.h"

namespace ratslam {
namespace {

TEST(Stamps, SurviveBothWaysToTheNanosecond) {
  for (const Stamp stamp :
       {Stamp{0}, Stamp{1}, Stamp{999999999}, Stamp{1000000000}, Stamp{1718000000123456789}}) {
    EXPECT_EQ(stampFromRos(stampToRos(stamp)), stamp);
  }
  EXPECT_EQ(stampFromRos(ros::Time(4294967295U, 999999999U)), Stamp{4294967295999999999});
}

TEST(Stamps, OutsideRosTimeAreRefused) {
  EXPECT_THROW(stampToRos(-1), std::runtime_error);
  EXPECT_THROW(stampToRos(Stamp{4294967296} * 1000000000), std::runtime_error);
}

TEST(Odometry, TwistOnlyMessageHasNoPose) {
  nav_msgs::Odometry message;
  message.header.stamp = ros::Time(3, 500);
  message.twist.twist.linear.x = -1.25;
  message.twist.twist.angular.z = 0.5;
  const OdometrySample sample = odometryFromMessage(message);
  EXPECT_EQ(sample.stamp, 3000000500);
  EXPECT_EQ(sample.speed, -1.25);
  EXPECT_EQ(sample.yaw_rate, 0.5);
  EXPECT_FALSE(sample.pose);
}

TEST(Odometry, PoseIsARigidTransformEvenFromASloppyQuaternion) {
  nav_msgs::Odometry message;
  message.pose.pose.position.x = 1.0;
  message.pose.pose.position.z = 3.0;
  message.pose.pose.orientation.z = 2.0 * std::sin(0.25);
  message.pose.pose.orientation.w = 2.0 * std::cos(0.25);
  const OdometrySample sample = odometryFromMessage(message);
  ASSERT_TRUE(sample.pose);
  EXPECT_NEAR(sample.pose->linear().determinant(), 1.0, 1e-12);
  EXPECT_NEAR(std::atan2(sample.pose->linear()(1, 0), sample.pose->linear()(0, 0)), 0.5, 1e-12);
  EXPECT_EQ(sample.pose->translation(), Eigen::Vector3d(1.0, 0.0, 3.0));
}

TEST(Odometry, WhatTheWireCarriesIsWhatTheOfflineRunnerUses) {
  for (int i = 0; i < 200; ++i) {
    OdometrySample sample;
    const double a = 0.37 * i;
    sample.pose = Eigen::Translation3d(std::sin(a), 1e3 * std::cos(a), a) *
                  Eigen::Isometry3d(Eigen::AngleAxisd(a, Eigen::Vector3d(1.0, a, -0.3).normalized()));
    nav_msgs::Odometry message;
    message.pose.pose = poseToMessage(*sample.pose);
    EXPECT_EQ(odometryFromMessage(message).pose->matrix(), asTransmitted(sample).pose->matrix()) << i;
  }
}

TEST(Odometry, ACovarianceOfZerosSaysNothing) {
  nav_msgs::Odometry message;
  EXPECT_FALSE(odometryFromMessage(message).covariance);
  message.twist.covariance[7] = -3.0;
  ASSERT_TRUE(odometryFromMessage(message).covariance);
  EXPECT_EQ((*odometryFromMessage(message).covariance)(1, 1), -3.0);
}

TEST(Odometry, WhatItSaysOfItselfSurvivesTheWire) {
  OdometrySample said;
  said.stamp = 7000000001;
  said.epoch = 3;
  said.bridged = true;
  said.unit = UnitOfLength{0.02, 0.001, 0.006};
  said.correction.emplace();
  said.correction->from = 5000000001;
  said.correction->to = 6000000002;
  said.correction->motion = Eigen::Translation3d(1.0, -2.0, 0.5) *
                            Eigen::Isometry3d(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()));
  said.correction->covariance(2, 3) = 0.25;
  said.correction->way = {{5500000000, said.correction->motion}};
  OdometrySample heard;
  addQuality(qualityToMessage(said), heard);
  EXPECT_EQ(heard.epoch, said.epoch);
  EXPECT_TRUE(heard.bridged);
  EXPECT_EQ(heard.unit->anchor_sigma, said.unit->anchor_sigma);
  EXPECT_EQ(heard.unit->walk_sigma, said.unit->walk_sigma);
  EXPECT_EQ(heard.unit->constant_sigma, said.unit->constant_sigma);
  EXPECT_EQ(heard.correction->from, said.correction->from);
  EXPECT_EQ(heard.correction->to, said.correction->to);
  EXPECT_EQ(heard.correction->motion.matrix(), asTransmitted(said).correction->motion.matrix());
  EXPECT_EQ(heard.correction->covariance, said.correction->covariance);
  ASSERT_EQ(heard.correction->way.size(), 1U);
  EXPECT_EQ(heard.correction->way[0].stamp, 5500000000);
  EXPECT_EQ(heard.correction->way[0].motion.matrix(), asTransmitted(said).correction->way[0].motion.matrix());

  OdometrySample silent;
  addQuality(qualityToMessage(OdometrySample()), silent);
  EXPECT_FALSE(silent.unit);
  EXPECT_FALSE(silent.correction);
  said.unit->anchor_sigma.reset();
  addQuality(qualityToMessage(said), heard);
  EXPECT_FALSE(heard.unit->anchor_sigma);
}

TEST(Odometry, NotANumberIsLeftForTheTimelineToRefuse) {
  nav_msgs::Odometry message;
  message.pose.pose.orientation.w = std::numeric_limits<double>::quiet_NaN();
  const OdometrySample sample = odometryFromMessage(message);
  ASSERT_TRUE(sample.pose);
  EXPECT_FALSE(sample.pose->matrix().allFinite());
}

TEST(Events, ViewSurvivesTheWire) {
  ViewEvent view;
  view.stamp = 123456789012;
  view.id = 4000000000U;
  view.relative_rad = -3.1;
  const ViewEvent back = viewFromMessage(viewToMessage(view));
  EXPECT_EQ(back.stamp, view.stamp);
  EXPECT_EQ(back.id, view.id);
  EXPECT_EQ(back.relative_rad, view.relative_rad);
}

TEST(Events, ActionSurvivesTheWire) {
  TopologicalAction action;
  action.stamp = 5000000001;
  action.kind = ActionKind::kCreateEdge;
  action.src_id = 17;
  action.dest_id = 3;
  action.relative_rad = 0.25;
  const TopologicalAction back = actionFromMessage(actionToMessage(action));
  EXPECT_EQ(back.stamp, action.stamp);
  EXPECT_EQ(back.kind, action.kind);
  EXPECT_EQ(back.src_id, action.src_id);
  EXPECT_EQ(back.dest_id, action.dest_id);
  EXPECT_EQ(back.relative_rad, action.relative_rad);
}

TEST(Events, UnknownActionIsNamed) {
  ratslam_ros::TopologicalAction message;
  message.action = 4;
  try {
    actionFromMessage(message);
    FAIL() << "accepted";
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("action 4"), std::string::npos) << e.what();
  }
}

TEST(Events, GeometrySurvivesTheWire) {
  const RecallGeometry geometry{7,   21, 0.1,        -2.0,       3.0, 0.4,  0.01,
                                0.2, 85, 5000000003, 4000000002, 1.5, 0.25, -0.4};
  const RecallGeometry back = geometryFromMessage(geometryToMessage(geometry));
  EXPECT_EQ(back.stamp, geometry.stamp);
  EXPECT_EQ(back.view_id, geometry.view_id);
  EXPECT_EQ(back.relative_rad, geometry.relative_rad);
  EXPECT_EQ(back.direction_rad, geometry.direction_rad);
  EXPECT_EQ(back.distance, geometry.distance);
  EXPECT_EQ(back.sigma_distance, geometry.sigma_distance);
  EXPECT_EQ(back.sigma_rotation, geometry.sigma_rotation);
  EXPECT_EQ(back.sigma_direction, geometry.sigma_direction);
  EXPECT_EQ(back.inliers, geometry.inliers);
  EXPECT_EQ(back.template_stamp, geometry.template_stamp);
  EXPECT_EQ(back.companion_stamp, geometry.companion_stamp);
  EXPECT_EQ(back.distance_ratio, geometry.distance_ratio);
  EXPECT_EQ(back.sigma_ratio, geometry.sigma_ratio);
  EXPECT_EQ(back.ahead, geometry.ahead);
}

TEST(Poses, YawAndTransformAgree) {
  for (const double yaw : {-3.0, -0.5, 0.0, 1.5, kPi}) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.rotate(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()));
    pose.pretranslate(Eigen::Vector3d(1.0, -2.0, 0.5));
    const geometry_msgs::Pose message = poseToMessage(pose);
    const geometry_msgs::Quaternion expected = yawToMessage(yaw);
    const double same = message.orientation.z * expected.z + message.orientation.w * expected.w;
    EXPECT_NEAR(std::abs(same), 1.0, 1e-12) << yaw;
    EXPECT_EQ(message.position.x, 1.0);
    EXPECT_EQ(message.position.y, -2.0);
    EXPECT_EQ(message.position.z, 0.5);
  }
}

}  // namespace
}  // namespace ratslam
