#include "ratslam_ros/support/stream_watch.h"

#include <gtest/gtest.h>

#include "ratslam_ros/support/decision_source.h"

namespace ratslam {
namespace {

TEST(SimilarTopics, AreThoseOfTheTypeOrTheName) {
  const std::vector<ros::master::TopicInfo> published{{"/robot/odom", "nav_msgs/Odometry"},
                                                      {"/husky/filtered", "nav_msgs/Odometry"},
                                                      {"/other/odom", "geometry_msgs/TwistStamped"},
                                                      {"/scan", "sensor_msgs/LaserScan"},
                                                      {"/kitti/odom", "nav_msgs/Odometry"}};
  EXPECT_EQ(
      similarTopics("/kitti/odom", "nav_msgs/Odometry", published),
      (std::vector<std::string>{"/robot/odom [nav_msgs/Odometry]", "/husky/filtered [nav_msgs/Odometry]",
                                "/other/odom [geometry_msgs/TwistStamped]"}));
}

TEST(SimilarTopics, TheSameImagesInAnotherTransportComeFirstAndOwnPicturesAreNone) {
  const std::vector<ros::master::TopicInfo> published{
      {"/cam/LocalView/View", "sensor_msgs/Image"},
      {"/front/image_raw", "sensor_msgs/Image"},
      {"/cam/camera/image/compressed", "sensor_msgs/CompressedImage"}};
  EXPECT_EQ(similarTopics("/cam/camera/image", "sensor_msgs/Image", published),
            (std::vector<std::string>{"/cam/camera/image/compressed [sensor_msgs/CompressedImage] (read with "
                                      "_image_transport:=compressed)",
                                      "/front/image_raw [sensor_msgs/Image]"}));
  EXPECT_EQ(similarTopics("/front/image_raw/compressed", "sensor_msgs/CompressedImage", published).front(),
            "/front/image_raw [sensor_msgs/Image] (read with _image_transport:=raw)");
}

TEST(SimilarTopics, ATopicOfAnotherTypeIsNamedWithItsBase) {
  const std::vector<ros::master::TopicInfo> published{
      {"/cam/image_raw/compressed", "sensor_msgs/CompressedImage"}, {"/odom", "geometry_msgs/TwistStamped"}};
  const std::string named =
      "/cam/image_raw/compressed [sensor_msgs/CompressedImage] (its base topic is /cam/image_raw, to be read "
      "with "
      "_image_transport:=compressed)";
  EXPECT_EQ(similarTopics("/cam/image_raw/compressed", "sensor_msgs/Image", published).front(), named);
  EXPECT_EQ(
      similarTopics("/cam/image_raw/compressed/compressed", "sensor_msgs/CompressedImage", published).front(),
      named);
  EXPECT_EQ(similarTopics("/odom", "nav_msgs/Odometry", published).front(),
            "/odom [geometry_msgs/TwistStamped] (this topic has another type)");
}

class SyncTimeoutTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ros::Time::init();
    setTime(100.0);
  }
  void TearDown() override { ros::Time::shutdown(); }
  static void setTime(double seconds) { ros::Time::setNow(ros::Time(seconds)); }
  static void sleep(double seconds) { ros::WallDuration(seconds).sleep(); }

  SyncTimeout timeout_{0.05};
};

TEST_F(SyncTimeoutTest, GivesUpOnASilentStreamAndWaitsAgainOnceItSpeaks) {
  EXPECT_FALSE(timeout_.expired(true));
  sleep(0.06);
  setTime(100.06);
  EXPECT_TRUE(timeout_.expired(true));
  EXPECT_TRUE(timeout_.expired(true));
  timeout_.messageArrived();
  EXPECT_FALSE(timeout_.expired(true));
}

TEST_F(SyncTimeoutTest, NothingWaitingIsNoSilence) {
  EXPECT_FALSE(timeout_.expired(true));
  EXPECT_FALSE(timeout_.expired(false));
  sleep(0.06);
  setTime(101.0);
  EXPECT_FALSE(timeout_.expired(true));
}

TEST_F(SyncTimeoutTest, APausedPlayerIsNoSilence) {
  EXPECT_FALSE(timeout_.expired(true));
  sleep(0.06);
  EXPECT_FALSE(timeout_.expired(true));
}

TEST_F(SyncTimeoutTest, AFastPlayerIsNoSilence) {
  EXPECT_FALSE(timeout_.expired(true));
  setTime(200.0);
  EXPECT_FALSE(timeout_.expired(true));
}

TEST(DecisionSource, FollowsStateWhereverSomebodyPublishesIt) {
  DecisionSource both("auto", [] { return true; });
  EXPECT_FALSE(both.takesAction());  // the first action may overtake the first state
  EXPECT_TRUE(both.takesState());
  DecisionSource actions_only("auto", [] { return false; });
  EXPECT_TRUE(actions_only.takesAction());
  EXPECT_FALSE(actions_only.takesState());
  DecisionSource state_first("auto", [] { return false; });
  EXPECT_TRUE(state_first.takesState());
  EXPECT_FALSE(state_first.takesAction());
}

TEST(DecisionSource, ObeysItsParameter) {
  DecisionSource state("state", [] { return false; });
  EXPECT_FALSE(state.takesAction());
  EXPECT_TRUE(state.takesState());
  DecisionSource action("action", [] { return true; });
  EXPECT_FALSE(action.takesState());
  EXPECT_TRUE(action.takesAction());
}

}  // namespace
}  // namespace ratslam
