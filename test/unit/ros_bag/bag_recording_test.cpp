#include "ratslam_ros/bag/bag_recording.h"

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <vector>

namespace ratslam {
namespace {

namespace fs = std::filesystem;

class BagRecordingTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("bag_recording_test_" + std::to_string(getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  static void writeImage(rosbag::Bag& bag, const std::string& topic, double at) {
    sensor_msgs::Image message;
    message.header.stamp = ros::Time(at);
    message.width = message.height = message.step = 4;
    message.encoding = "mono8";
    message.data.assign(16, static_cast<std::uint8_t>(at));
    bag.write(topic, ros::Time(at), message);
  }

  static void writeOdometry(rosbag::Bag& bag, const std::string& topic, double at) {
    nav_msgs::Odometry message;
    message.header.stamp = ros::Time(at);
    message.twist.twist.linear.x = at;
    bag.write(topic, ros::Time(at), message);
  }

  /// Three images with odometry between them, and some other topics.
  std::string goodBag() const {
    const std::string name = path("good.bag");
    rosbag::Bag bag(name, rosbag::bagmode::Write);
    for (const double at : {10.0, 11.0, 12.0}) {
      writeImage(bag, "/kitti/camera/image", at);
      writeOdometry(bag, "/kitti/odom", at + 0.5);
      writeOdometry(bag, "/kitti/ground_truth", at);
    }
    return name;
  }

  static std::string messageOf(const std::function<void()>& action) {
    try {
      action();
    } catch (const std::runtime_error& e) {
      return e.what();
    }
    return "";
  }

  static void expectParts(const std::string& message, const std::vector<std::string>& parts) {
    for (const std::string& part : parts) EXPECT_NE(message.find(part), std::string::npos) << message;
  }

  fs::path folder_;
};

TEST_F(BagRecordingTest, GivesImagesAndOdometryInTheOrderOfRecording) {
  BagTopics topics;
  topics.with_odometry = true;
  BagRecording recording(goodBag(), topics);
  EXPECT_EQ(recording.imageCount(), 3U);
  EXPECT_EQ(recording.topics().images, "/kitti/camera/image");
  EXPECT_EQ(recording.topics().odometry, "/kitti/odom");
  std::vector<Stamp> stamps;
  while (auto item = recording.next()) {
    if (const auto* image = std::get_if<RecordedImage>(&*item)) {
      stamps.push_back(image->stamp);
      EXPECT_EQ(image->decode().at<std::uint8_t>(1, 1), image->stamp / 1000000000);
    } else {
      stamps.push_back(std::get<OdometrySample>(*item).stamp);
    }
  }
  EXPECT_EQ(stamps, (std::vector<Stamp>{10000000000, 10500000000, 11000000000, 11500000000, 12000000000,
                                        12500000000}));
}

TEST_F(BagRecordingTest, LeavesOdometryOutUnlessItIsWanted) {
  BagRecording recording(goodBag(), {"kitti/camera/image", "", false});
  int items = 0;
  while (recording.next()) ++items;
  EXPECT_EQ(items, 3);
}

TEST_F(BagRecordingTest, DecodesCompressedImagesAndReportsCorruptOnesWhenAsked) {
  const std::string name = path("compressed.bag");
  {
    rosbag::Bag bag(name, rosbag::bagmode::Write);
    sensor_msgs::CompressedImage message;
    message.header.stamp = ros::Time(1.0);
    cv::imencode(".jpg", cv::Mat(40, 60, CV_8UC1, cv::Scalar(90)), message.data);
    bag.write("/camera/image/compressed", ros::Time(1.0), message);
    message.header.stamp = ros::Time(2.0);
    message.data.resize(message.data.size() / 2);
    bag.write("/camera/image/compressed", ros::Time(2.0), message);
    sensor_msgs::CameraInfo info;
    info.width = 60;
    info.height = 40;
    info.K = {50.0, 0.0, 30.0, 0.0, 51.0, 20.0, 0.0, 0.0, 1.0};
    bag.write("/camera/camera_info", ros::Time(1.0), info);
  }
  BagRecording recording(name, BagTopics());
  EXPECT_EQ(std::get<RecordedImage>(*recording.next()).decode().size(), cv::Size(60, 40));
  const RecordedItem corrupt = *recording.next();
  expectParts(messageOf([&] { std::get<RecordedImage>(corrupt).decode(); }), {"corrupt"});
  ASSERT_TRUE(recording.camera());
  EXPECT_EQ(recording.camera()->fy, 51.0);
}

TEST_F(BagRecordingTest, MissingTopicIsAnsweredWithThoseThereAre) {
  const std::string bag = goodBag();
  const auto open = [&](const BagTopics& topics) { return messageOf([&] { BagRecording(bag, topics); }); };
  expectParts(open({"/camera/image", "", false}),
              {"no topic /camera/image", "/kitti/camera/image [sensor_msgs/Image]",
               "/kitti/odom [nav_msgs/Odometry]"});
  expectParts(open({"/kitti/odom", "", false}), {"/kitti/odom is nav_msgs/Odometry, not images"});
  expectParts(open({"", "/wheel/odom", true}), {"no topic /wheel/odom", "/kitti/odom [nav_msgs/Odometry]"});
}

TEST_F(BagRecordingTest, AmbiguousTopicsMustBeNamed) {
  const std::string name = path("stereo.bag");
  {
    rosbag::Bag bag(name, rosbag::bagmode::Write);
    writeImage(bag, "/left/image", 1.0);
    writeImage(bag, "/right/image", 1.0);
  }
  expectParts(messageOf([&] { BagRecording(name, BagTopics()); }),
              {"more than one", "/left/image", "/right/image"});
  EXPECT_NO_THROW(BagRecording(name, BagTopics{"/right/image", "", false}));
}

TEST_F(BagRecordingTest, UnusableFilesAreRefusedWithAReason) {
  const auto open = [](const std::string& name) {
    return messageOf([&] { BagRecording(name, BagTopics()); });
  };
  expectParts(open(path("nothing.bag")), {"nothing.bag", "cannot open"});

  std::ofstream(path("empty.bag")).flush();
  expectParts(open(path("empty.bag")), {"empty.bag", "empty"});

  std::ofstream(path("text.bag")) << "stamp,x,y\n1,2,3\n";
  expectParts(open(path("text.bag")), {"text.bag", "not a readable bag"});

  { rosbag::Bag bag(path("no_messages.bag"), rosbag::bagmode::Write); }
  expectParts(open(path("no_messages.bag")), {"no messages at all"});

  const std::string good = goodBag();
  fs::copy_file(good, path("truncated.bag"));
  fs::resize_file(path("truncated.bag"), fs::file_size(good) * 2 / 3);
  expectParts(open(path("truncated.bag")), {"truncated.bag", "truncated"});

  // As a recorder leaves it that was killed: whole chunks, no index at the end.
  rosbag::Bag unfinished(path("unfinished.bag"), rosbag::bagmode::Write);
  unfinished.setChunkThreshold(100);
  for (int i = 1; i < 50; ++i) writeImage(unfinished, "/camera/image", i);
  fs::copy_file(path("unfinished.bag"), path("unindexed.bag"));
  expectParts(open(path("unindexed.bag")), {"unindexed.bag", "rosbag reindex"});
}

}  // namespace
}  // namespace ratslam
