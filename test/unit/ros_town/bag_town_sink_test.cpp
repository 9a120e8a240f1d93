#include "town/ros/bag_town_sink.h"

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/view.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <map>

#include "ratslam_ros/bag/bag_recording.h"

namespace ratslam {
namespace {

/// A drive straight ahead, then one frame turned left by a tenth of a radian.
TEST(BagTownSink, WritesADriveThatReadsBackAsARecordingWithTruth) {
  const std::string path =
      (std::filesystem::temp_directory_path() / ("town_" + std::to_string(getpid()) + ".bag")).string();
  TownOptions options;
  options.out = path;
  options.size = "64x48";
  {
    BagTownSink sink(options, "town");
    for (int i = 0; i < 3; ++i) {
      TownFrame frame;
      frame.index = i;
      frame.stamp = Stamp{100000000} * i;
      frame.image = cv::Mat(48, 64, CV_8UC1, cv::Scalar(10 * i));
      const double turn = i == 2 ? -0.1 : 0.0;  // about the camera's y axis, which points down
      frame.T_world_camera = Eigen::Translation3d(5.0, -1.65, 2.0 * i) *
                             Eigen::Isometry3d(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()));
      frame.wheel.emplace().stamp = frame.stamp;
      frame.wheel->speed = 20.0;
      frame.wheel->yaw_rate = -turn / 0.1;
      if (i == 0) frame.gps = GpsFix{49.0, 8.4, 112.0, 2.0, 0.0, 0.0};
      sink.add(frame);
    }
    sink.finish();
  }

  BagRecording recording(path, BagTopics{"", "/town/odom", true});
  EXPECT_EQ(recording.imageCount(), 3U);
  ASSERT_TRUE(recording.camera());
  EXPECT_EQ(recording.camera()->width, 64);

  rosbag::Bag bag(path, rosbag::bagmode::Read);
  std::map<std::string, int> counts;
  nav_msgs::Odometry truth;
  nav_msgs::Odometry wheel;
  for (const rosbag::MessageInstance& instance : rosbag::View(bag)) {
    ++counts[instance.getTopic()];
    if (instance.getTopic() == "/town/ground_truth") truth = *instance.instantiate<nav_msgs::Odometry>();
    if (instance.getTopic() == "/town/odom") wheel = *instance.instantiate<nav_msgs::Odometry>();
  }
  EXPECT_EQ(counts["/town/camera/image"], 3);
  EXPECT_EQ(counts["/town/camera/camera_info"], 3);
  EXPECT_EQ(counts["/town/gps"], 1);
  EXPECT_EQ(counts["/tf_static"], 1);
  EXPECT_NEAR(truth.pose.pose.position.x, 4.0, 1e-12);
  EXPECT_NEAR(truth.pose.pose.position.y, 0.0, 1e-12);
  EXPECT_NEAR(truth.twist.twist.linear.x, 20.0, 1e-6);
  EXPECT_NEAR(2.0 * std::asin(truth.pose.pose.orientation.z), 0.1, 1e-12);
  EXPECT_NEAR(truth.twist.twist.angular.z, 1.0, 1e-6);
  EXPECT_EQ(wheel.twist.twist.linear.x, 20.0);
  EXPECT_EQ(truth.header.stamp, ros::Time(1600000000, 200000000));
  bag.close();
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace ratslam
