#include "ratslam_ros/bag/bag_recording.h"

#include <gtest/gtest.h>
#include <nav_msgs/Odometry.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "ratslam_ros/OdometryQuality.h"
#include "unit/message_of.h"

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

  static void writeImage(rosbag::Bag& bag, const std::string& topic, double at, std::uint32_t width = 4,
                         std::uint32_t height = 4) {
    sensor_msgs::Image message;
    message.header.stamp = ros::Time(at);
    message.width = message.step = width;
    message.height = height;
    message.encoding = "mono8";
    message.data.assign(std::size_t{width} * height, static_cast<std::uint8_t>(at));
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

  static std::vector<OdometrySample> samplesOf(const std::string& name) {
    BagRecording recording(name, {"", "", true});
    std::vector<OdometrySample> samples;
    while (const auto item = recording.next()) {
      if (const auto* sample = std::get_if<OdometrySample>(&*item)) samples.push_back(*sample);
    }
    return samples;
  }

  static std::string bytesOf(const std::string& name) {
    std::ifstream file(name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
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

TEST_F(BagRecordingTest, TakesWhatTheOdometrySaysOfItself) {
  const std::string name = goodBag();
  {
    rosbag::Bag bag(name, rosbag::bagmode::Append);
    for (const double at : {10.5, 12.5}) {  // nothing of the sample at 11.5
      ratslam_ros::OdometryQuality message;
      message.header.stamp = ros::Time(at);
      message.epoch = 3;
      message.bridged = at > 12.0 ? 1 : 0;
      message.unit_anchor_sigma = -1.0;
      message.unit_walk_sigma = 0.02;
      bag.write("/kitti/odom_quality", ros::Time(at + 0.01), message);
    }
  }
  const std::vector<OdometrySample> samples = samplesOf(name);
  ASSERT_EQ(samples.size(), 3U);
  ASSERT_TRUE(samples[0].unit);
  EXPECT_EQ(samples[0].unit->walk_sigma, 0.02);
  EXPECT_FALSE(samples[0].unit->anchor_sigma);
  EXPECT_EQ(samples[0].epoch, 3U);
  EXPECT_FALSE(samples[1].unit);
  EXPECT_TRUE(samples[2].bridged);
}

TEST_F(BagRecordingTest, EveryLapOfALoopHasItsOwnQualities) {
  rosbag::Bag bag(path("laps.bag"), rosbag::bagmode::Write);
  writeImage(bag, "/camera/image", 1.0);
  for (std::uint32_t k = 0; k < 15; ++k) {
    nav_msgs::Odometry odometry;
    ratslam_ros::OdometryQuality quality;
    odometry.header.stamp = quality.header.stamp = ros::Time(10 + k % 5, 0);
    quality.epoch = 1 + k / 5;
    bag.write("/odom", ros::Time(100 + k, 0), odometry);
    if (k % 5 != 2) bag.write("/odom_quality", ros::Time(100 + k, 5), quality);  // one is lost
  }
  bag.close();
  std::vector<std::uint32_t> laps;
  for (const OdometrySample& sample : samplesOf(path("laps.bag"))) laps.push_back(sample.epoch);
  EXPECT_EQ(laps, (std::vector<std::uint32_t>{1, 1, 0, 1, 1, 2, 2, 0, 2, 2, 3, 3, 0, 3, 3}));
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
  expectParts(test::messageOf([&] { std::get<RecordedImage>(corrupt).decode(); }), {"corrupt"});
  ASSERT_TRUE(recording.camera());
  EXPECT_EQ(recording.camera()->fy, 51.0);
}

TEST_F(BagRecordingTest, MissingTopicIsAnsweredWithThoseThereAre) {
  const std::string bag = goodBag();
  const auto open = [&](const BagTopics& topics) {
    return test::messageOf([&] { BagRecording(bag, topics); });
  };
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
  expectParts(test::messageOf([&] { BagRecording(name, BagTopics()); }),
              {"more than one", "/left/image", "/right/image"});
  EXPECT_NO_THROW(BagRecording(name, BagTopics{"/right/image", "", false}));
}

TEST_F(BagRecordingTest, NamesAndNumbersOfTopicsLeaveTheMessageOneShortLine) {
  const std::string name = path("many.bag");
  {
    rosbag::Bag bag(name, rosbag::bagmode::Write);
    for (int i = 0; i < 300; ++i) writeImage(bag, "/a\n\x1b[31m" + std::to_string(i), 10.0);
  }
  for (const std::string& wanted : {std::string(), std::string("/not\nthere")}) {
    BagTopics topics;
    topics.images = wanted;
    const std::string message = test::messageOf([&] { BagRecording recording(name, topics); });
    EXPECT_LT(message.size(), 4000U);
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_EQ(message.find('\x1b'), std::string::npos);
    expectParts(message, {" and 260 more"});
  }
}

TEST_F(BagRecordingTest, UnusableFilesAreRefusedWithAReason) {
  const auto open = [](const std::string& name) {
    return test::messageOf([&] { BagRecording(name, BagTopics()); });
  };
  expectParts(open(path("nothing.bag")), {"nothing.bag", "cannot open"});

  std::ofstream(path("empty.bag")).flush();
  expectParts(open(path("empty.bag")), {"empty.bag", "empty"});

  std::ofstream(path("text.bag")) << "stamp,x,y\n1,2,3\n";
  expectParts(open(path("text.bag")), {"text.bag", "not a readable bag"});

  // rosbag takes it for a bag and asks for 3 GB.
  std::ofstream(path("nearly.bag"), std::ios::binary) << "#ROS. V2.0\n\xc0\xc0\xc0\xc0\xc0";
  expectParts(open(path("nearly.bag")), {"nearly.bag", "not a readable bag", "#ROSBAG V2.0"});

  std::ofstream(path("a.db3"), std::ios::binary) << std::string("SQLite format 3\0", 16) << "...";
  expectParts(open(path("a.db3")), {"a.db3", "not a readable bag", "ROS 2", "rosbags-convert"});
  std::ofstream(path("a.mcap"), std::ios::binary) << "\x89MCAP0\r\n...";
  expectParts(open(path("a.mcap")), {"a.mcap", "not a readable bag", "ROS 2", "rosbags-convert"});

  { rosbag::Bag bag(path("no_messages.bag"), rosbag::bagmode::Write); }
  expectParts(open(path("no_messages.bag")), {"no messages at all"});

  const std::string good = goodBag();
  fs::copy_file(good, path("truncated.bag"));
  fs::resize_file(path("truncated.bag"), fs::file_size(good) * 2 / 3);
  expectParts(open(path("truncated.bag")),
              {"truncated.bag", "truncated", "rosbag reindex " + path("truncated.bag")});

  fs::create_directories(path("folder.bag"));
  expectParts(open(path("folder.bag")), {"folder.bag", "no regular file"});
  ASSERT_EQ(mkfifo(path("pipe.bag").c_str(), 0600), 0);
  expectParts(open(path("pipe.bag")), {"pipe.bag", "no regular file"});

  // As a recorder leaves it that was killed: whole chunks, no index at the end.
  rosbag::Bag unfinished(path("unfinished.bag"), rosbag::bagmode::Write);
  unfinished.setChunkThreshold(100);
  for (int i = 1; i < 50; ++i) writeImage(unfinished, "/camera/image", i);
  fs::copy_file(path("unfinished.bag"), path("unindexed.bag"));
  expectParts(open(path("unindexed.bag")), {"unindexed.bag", "rosbag reindex"});
  fs::resize_file(path("unindexed.bag"), fs::file_size(path("unindexed.bag")) - 50);
  expectParts(open(path("unindexed.bag")), {"unindexed.bag", "rosbag reindex"});
}

TEST_F(BagRecordingTest, LengthsThatADamagedBagClaimsAreLookedAtFirst) {
  const std::string good = goodBag();
  const std::string bytes = bytesOf(good);
  const auto damaged = [&](const std::string& before, std::size_t distance, std::uint32_t value) {
    std::string changed = bytes;
    const std::size_t at = changed.find(before);
    EXPECT_NE(at, std::string::npos) << before;
    std::memcpy(&changed[at + before.size() + distance], &value, sizeof value);
    const std::string name = path("damaged.bag");
    std::ofstream(name, std::ios::binary) << changed;
    return name;
  };
  // The chunk's unpacked size, the length behind its header, and where its index points.
  expectParts(test::messageOf([&] { BagRecording(damaged("size=", 0, 0xFFFFFFF0U), BagTopics()); }),
              {"damaged.bag", "claims to hold 4294967280"});
  expectParts(test::messageOf([&] { BagRecording(damaged("size=", 4, 0x7FFFFFF0U), BagTopics()); }),
              {"damaged.bag", "beyond the end of the file"});
  // The lengths of fields in the header of the file's first record, and of a record within the chunk.
  expectParts(test::messageOf([&] { BagRecording(damaged("#ROSBAG V2.0\n", 4, 0x2D04U), BagTopics()); }),
              {"damaged.bag", "byte 13: the fields of a record's header do not fit into it"});
  expectParts(test::messageOf([&] { BagRecording(damaged("op=\x02", 0, 0x2D04U), BagTopics()); }),
              {"damaged.bag", "the fields of a record's header do not fit into it"});
  // Where the index begins: within a record, whose bytes rosbag would take for lengths.
  expectParts(test::messageOf([&] { BagRecording(damaged("index_pos=", 0, 100U), BagTopics()); }),
              {"damaged.bag", "byte 100: no record is where the header says that the index begins"});
  // The length of an image's pixels, behind its encoding, byte order and step: the message is damaged, no more.
  BagRecording recording(damaged("mono8", 5, 0xFFFFFFF0U), {"", "", false});
  const RecordedItem item = *recording.next();
  expectParts(test::messageOf([&] { std::get<RecordedImage>(item).decode(); }), {"damaged message"});
  int others = 0;
  while (recording.next()) ++others;
  EXPECT_EQ(others, 2);
}

TEST_F(BagRecordingTest, WhatACompressedChunkUnpacksToIsLookedAtBeforeRosbagReadsIt) {
  for (const auto compression : {rosbag::compression::BZ2, rosbag::compression::LZ4}) {
    const std::string name = path("packed.bag");
    {
      rosbag::Bag bag(name, rosbag::bagmode::Write);
      bag.setCompression(compression);
      for (int i = 1; i < 4; ++i) writeImage(bag, "/camera/image", i);
    }
    const std::string bytes = bytesOf(name);
    const std::size_t size_at = bytes.find("size=") + 5;
    std::uint32_t size = 0;
    std::memcpy(&size, &bytes[size_at], sizeof size);
    // The first entry of the index: 1 s, and the place of the message.
    const std::size_t entry = bytes.find(std::string("\x01\0\0\0\0\0\0\0", 8), bytes.find("ver=") + 5);
    ASSERT_NE(entry, std::string::npos);
    const auto messageOfDamaged = [&](std::size_t at, std::uint32_t value) {
      std::string changed = bytes;
      std::memcpy(&changed[at], &value, sizeof value);
      std::ofstream(name, std::ios::binary) << changed;
      return test::messageOf([&] {
        BagRecording recording(name, {"", "", false});
        while (recording.next()) {
        }
      });
    };
    expectParts(messageOfDamaged(size_at, size + 1000),
                {"packed.bag", "does not unpack to the", "that it claims"});
    expectParts(messageOfDamaged(size_at, size - 1),
                {"packed.bag", "does not unpack to the", "that it claims"});
    // Within the pixels of an image, which are no lengths; at the connection, which rosbag would not pass.
    expectParts(messageOfDamaged(entry + 8, size - 12),
                {"packed.bag", "of what a chunk unpacks to: a record reaches beyond the end of its chunk"});
    expectParts(messageOfDamaged(entry + 8, 0), {"packed.bag", "an index points at what is no message"});
    expectParts(messageOfDamaged(bytes.find("size=") + 40, 0x12345678U),
                {"packed.bag", "does not unpack to the"});

    std::ofstream(name, std::ios::binary) << bytes;
    BagRecording recording(name, {"", "", false});
    int images = 0;
    while (recording.next()) ++images;
    EXPECT_EQ(images, 3);
  }
}

TEST_F(BagRecordingTest, AnotherDefinitionOfATypeIsNamed) {
  const std::string name = goodBag();
  std::string bytes = bytesOf(name);
  const std::string sum = ros::message_traits::MD5Sum<sensor_msgs::Image>::value();
  for (std::size_t at = bytes.find(sum); at != std::string::npos; at = bytes.find(sum, at)) bytes[at] = 'x';
  std::ofstream(name, std::ios::binary) << bytes;
  expectParts(test::messageOf([&] { BagRecording(name, BagTopics()); }),
              {"/kitti/camera/image is sensor_msgs/Image of another definition", "x" + sum.substr(1), sum});
}

TEST_F(BagRecordingTest, TheFirstUsableCalibrationCounts) {
  const auto recorded = [this](const std::string& image_topic,
                               const std::vector<sensor_msgs::CameraInfo>& infos) {
    const std::string name = path("camera.bag");
    rosbag::Bag bag(name, rosbag::bagmode::Write);
    writeImage(bag, "/camera/" + image_topic, 1.0);  // an odd one, as at the start of a stream
    for (const double at : {2.0, 3.0}) writeImage(bag, "/camera/" + image_topic, at, 60, 40);
    for (const sensor_msgs::CameraInfo& info : infos) bag.write("/camera/camera_info", ros::Time(1.0), info);
    bag.close();
    return name;
  };
  const sensor_msgs::CameraInfo zero;
  sensor_msgs::CameraInfo whole;
  whole.width = 60;
  whole.height = 40;
  whole.K = {50.0, 0.0, 30.0, 0.0, 51.0, 20.0, 0.0, 0.0, 1.0};
  whole.P = {45.0, 0.0, 29.0, 0.0, 0.0, 46.0, 21.0, 0.0, 0.0, 0.0, 1.0, 0.0};
  whole.distortion_model = "plumb_bob";
  whole.D = {-0.2, 0.1, 0.0, 0.0, 0.0};
  sensor_msgs::CameraInfo only_p;
  only_p.P = whole.P;
  EXPECT_EQ(BagRecording(recorded("image", {zero, whole}), BagTopics()).camera()->fx, 50.0);
  const auto rectified = BagRecording(recorded("image_rect", {whole}), BagTopics()).camera();
  EXPECT_EQ(rectified->fx, 45.0);
  EXPECT_EQ(rectified->model, LensModel::kNone);
  const auto by_p = BagRecording(recorded("image", {only_p}), BagTopics()).camera();
  EXPECT_EQ(by_p->fy, 46.0);
  EXPECT_EQ(by_p->width, 60) << "the size is that of the images";
  whole.distortion_model = "equidistant";
  whole.D = {0.1, 0.0, 0.0, 0.0, 0.0};
  EXPECT_EQ(BagRecording(recorded("image", {whole}), BagTopics()).camera()->coefficients.size(), 4U);
  const BagRecording none(recorded("image", {zero, zero}), BagTopics());
  expectParts(test::messageOf([&] { none.camera(); }), {"camera.bag: /camera/camera_info", "all zero"});
  sensor_msgs::CameraInfo of_another_size = whole;
  of_another_size.width = 640;
  of_another_size.K[0] = 500.0;
  EXPECT_EQ(BagRecording(recorded("image", {of_another_size, whole}), BagTopics()).camera()->fx, 50.0);
  const BagRecording other(recorded("image", {of_another_size}), BagTopics());
  expectParts(test::messageOf([&] { other.camera(); }),
              {"camera.bag: /camera/camera_info", "for images of 640x40"});
  sensor_msgs::CameraInfo skewed = whole;
  skewed.K[1] = 4.0;
  const BagRecording skew(recorded("image", {skewed}), BagTopics());
  expectParts(test::messageOf([&] { skew.camera(); }), {"K[1] (skew)", "value 4", "must be 0"});
}

}  // namespace
}  // namespace ratslam
