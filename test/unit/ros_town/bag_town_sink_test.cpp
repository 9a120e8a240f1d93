#include "town/ros/bag_town_sink.h"

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <rosbag/view.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <stdexcept>

#include "ratslam_ros/bag/bag_recording.h"
#include "town/town_run.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;

/// An empty folder that goes when the test ends, and options of a small bag in it.
class BagInFolder : public ::testing::Test {
 protected:
  BagInFolder() : folder_(fs::temp_directory_path() / ("town_bag_" + std::to_string(getpid()))) {
    fs::create_directory(folder_);
    options_.out = (folder_ / "drive.bag").string();
    options_.size = "64x48";
    options_.frames = 2;
  }
  ~BagInFolder() override { fs::remove_all(folder_); }

  /// What the sink says when it is made.
  std::string refusal(const std::string& root = "town") const {
    try {
      BagTownSink sink(options_, root);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
  TownOptions options_;
};

TEST_F(BagInFolder, IsNotOverwritten) {
  std::ofstream(options_.out) << "mine";
  EXPECT_NE(refusal().find("drive.bag is not allowed: it exists already"), std::string::npos) << refusal();
  EXPECT_EQ(fs::file_size(options_.out), 4U);
}

TEST_F(BagInFolder, IsNotBegunByADriveThatCannotBegin) {
  options_.trajectory = (folder_ / "missing.txt").string();
  BagTownSink sink(options_, "town");
  EXPECT_THROW(runTown(options_, sink, {}), std::runtime_error);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(BagInFolder, IsWholeOrNotThere) {
  rlimit usual{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &usual), 0);
  const rlimit small{200000, usual.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  TownFrame frame;
  frame.image = cv::Mat(48, 64, CV_8UC1, cv::Scalar(7));
  const auto fill = [&](int frames) {
    BagTownSink sink(options_, "town");
    for (int i = 0; i < frames; ++i, frame.stamp += 100000000) sink.add(frame);
    EXPECT_FALSE(fs::exists(options_.out));
    sink.finish();
  };
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);  // as a disk that is full
  EXPECT_THROW(fill(100), std::runtime_error);    // found out at the end
  EXPECT_THROW(fill(1000), std::runtime_error);   // found out on the way
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &usual), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_TRUE(fs::is_empty(folder_));
  fill(100);
  EXPECT_TRUE(fs::exists(options_.out));
  EXPECT_FALSE(fs::exists(options_.out + ".part"));
}

TEST_F(BagInFolder, SaysAtOnceWhatCannotBeWritten) {
  EXPECT_NE(refusal("a b").find("root: value a b is not allowed"), std::string::npos) << refusal("a b");
  EXPECT_EQ(refusal(""), "");
  EXPECT_EQ(refusal("/robot/one"), "");
  options_.layout = "recorder";
  EXPECT_NE(refusal().find("layout: value recorder is not allowed"), std::string::npos) << refusal();
  options_.layout = "kitti";
  options_.out = (folder_ / "none" / "drive.bag").string();
  EXPECT_NE(refusal().find(options_.out + ": cannot write"), std::string::npos) << refusal();
}

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
