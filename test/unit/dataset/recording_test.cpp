#include "ratslam/dataset/recording.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

#include "ratslam/dataset/kitti_folder.h"
#include "ratslam/dataset/odometry_file.h"
#include "ratslam/dataset/recorder_folder.h"
#include "ratslam/dataset/trajectory_io.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;

class DatasetTest : public ::testing::Test {
 protected:
  DatasetTest()
      : folder_(fs::temp_directory_path() /
                (std::string("dataset_") + ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "image_0");
  }
  ~DatasetTest() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name) << content;
  }
  void writeImages(int count) const {
    for (int i = 0; i < count; ++i) {
      cv::imwrite((folder_ / "image_0" / (std::to_string(100 + i) + ".png")).string(),
                  cv::Mat(4, 6, CV_8UC1, cv::Scalar(i)));
    }
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  template <class Action>
  static std::string complaint(Action action) {
    try {
      action();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

TEST_F(DatasetTest, KittiFolderHandsOutImagesInOrderHoweverManyThreadsDecode) {
  writeImages(23);
  std::string times;
  for (int i = 0; i < 23; ++i) times += std::to_string(0.1 * i) + "\n";
  write("times.txt", times);
  write("image_0/111.png", "this is no picture");
  for (const int threads : {1, 4}) {
    KittiFolder folder(folder_.string());
    EXPECT_EQ(folder.imageCount(), 23U);
    DecodeAhead ahead(folder, threads);
    int count = 0;
    while (auto item = ahead.next()) {
      const auto& image = std::get<DecodedImage>(*item);
      EXPECT_EQ(image.stamp, stampFromSeconds(0.1 * count));
      if (count == 11) {
        EXPECT_TRUE(image.image.empty());
        EXPECT_FALSE(image.error.empty());
      } else {
        ASSERT_FALSE(image.image.empty());
        EXPECT_EQ(image.image.at<std::uint8_t>(0, 0), count);
      }
      ++count;
    }
    EXPECT_EQ(count, 23);
  }
}

/// A bag that is cut off: what was read before the cut must not depend on how far the threads were ahead.
TEST(DecodeAhead, HandsOutAllThatWasReadBeforeAFailure) {
  struct CutOff : Recording {
    int read = 0;
    std::optional<RecordedItem> next() override {
      if (read == 5) throw std::runtime_error("cut off");
      RecordedImage image;
      image.stamp = ++read;
      image.decode = [] { return cv::Mat(2, 2, CV_8UC1, cv::Scalar(0)); };
      return image;
    }
    std::size_t imageCount() const override { return 9; }
  };
  for (const int threads : {1, 2, 8}) {
    CutOff recording;
    DecodeAhead ahead(recording, threads);
    for (Stamp stamp = 1; stamp <= 5; ++stamp) {
      const auto item = ahead.next();
      ASSERT_TRUE(item.has_value());
      EXPECT_EQ(std::get<DecodedImage>(*item).stamp, stamp);
    }
    EXPECT_THROW(ahead.next(), std::runtime_error);
  }
}

TEST_F(DatasetTest, DecodingCanBeAbandonedMidway) {
  writeImages(9);
  write("times.txt", "0\n1\n2\n3\n4\n5\n6\n7\n8\n");
  KittiFolder folder(folder_.string());
  DecodeAhead ahead(folder, 2);
  EXPECT_TRUE(ahead.next().has_value());
}

TEST_F(DatasetTest, FaultyFoldersAreNamed) {
  EXPECT_NE(complaint([&] { KittiFolder(path("nowhere")); }).find("nowhere/image_0"), std::string::npos);
  EXPECT_NE(complaint([&] { KittiFolder(folder_.string()); }).find("no .png or .jpg"), std::string::npos);
  writeImages(3);
  EXPECT_NE(complaint([&] { KittiFolder(folder_.string()); }).find("times.txt"), std::string::npos);
  write("times.txt", "0\n0.1\n");
  EXPECT_NE(complaint([&] { KittiFolder(folder_.string()); }).find("2 times for 3 images"),
            std::string::npos);
  write("times.txt", "0\nsoon\n2\n");
  EXPECT_NE(complaint([&] { KittiFolder(folder_.string()); }).find("times.txt:2: 'soon'"), std::string::npos);
}

TEST_F(DatasetTest, MoreTimesThanImagesAreSaid) {
  writeImages(4);
  write("times.txt", "0\n1\n2\n3\n");
  EXPECT_TRUE(KittiFolder(folder_.string()).remarks().empty());
  std::filesystem::remove(folder_ / "image_0" / "101.png");
  const auto remarks = KittiFolder(folder_.string()).remarks();
  ASSERT_EQ(remarks.size(), 1U);
  EXPECT_NE(remarks[0].find("times.txt: 4 times for 3 images"), std::string::npos) << remarks[0];
}

TEST_F(DatasetTest, OdometryThatNothingDrivesIsRefusedByLineAndValue) {
  const auto refused = [this](const std::string& row) {
    write("odometry.csv", "stamp,linear_x,angular_z\n0,1,0\n" + row + "\n");
    return complaint([this] { readOdometryCsv(path("odometry.csv")); });
  };
  EXPECT_NE(refused("1,1e308,0").find("odometry.csv:3: the speed 1e+308 m/s is out of range"),
            std::string::npos);
  EXPECT_NE(refused("1,1,-1e9").find("odometry.csv:3: the yaw rate -1e+09 rad/s"), std::string::npos);
}

TEST_F(DatasetTest, OdometryFileMayStateTheSpeedToTheSide) {
  write("odometry.csv", "stamp,linear_x,linear_y,angular_z\n1,0.5,-0.25,0\n2,0.5,,0\n");
  const auto read = readOdometryCsv(path("odometry.csv"));
  EXPECT_EQ(read.at(0).sideways, -0.25);
  EXPECT_EQ(read.at(1).sideways, 0.0);
}

TEST_F(DatasetTest, OdometryFileIsLaidIntoTheImagesByStamp) {
  writeImages(3);
  write("times.txt", "0\n1\n2\n");
  write("odometry.csv", "frame,stamp,linear_x,angular_z\n0,0,0,0\n1,0.5,2,0.25\n2,1,3,0\n3,2.5,4,0\n");
  RecordingWithOdometry recording(std::make_unique<KittiFolder>(folder_.string()),
                                  readOdometryCsv(path("odometry.csv")));
  std::string order;
  Stamp last = 0;
  while (auto item = recording.next()) {
    const auto* image = std::get_if<RecordedImage>(&*item);
    const Stamp stamp = image != nullptr ? image->stamp : std::get<OdometrySample>(*item).stamp;
    EXPECT_GE(stamp, last);
    last = stamp;
    order += image != nullptr ? 'i' : 'o';
  }
  EXPECT_EQ(order, "oiooiio");
}

TEST_F(DatasetTest, AnImageAheadOfTimeDoesNotTakeTheOdometryOfThoseAfterIt) {
  writeImages(5);
  write("times.txt", "0\n1\n4\n3\n4\n");
  write("odometry.csv", "stamp,linear_x,angular_z\n0,0,0\n1,1,0\n2,1,0\n3,1,0\n4,1,0\n5,1,0\n");
  RecordingWithOdometry recording(std::make_unique<KittiFolder>(folder_.string()),
                                  readOdometryCsv(path("odometry.csv")));
  std::string order;
  while (auto item = recording.next()) order += std::holds_alternative<RecordedImage>(*item) ? 'i' : 'o';
  EXPECT_EQ(order, "oioiooiioio") << "the third image comes before the odometry of second 4";
}

TEST_F(DatasetTest, OdometryFileNeedNotStateTheErrorOfTheUnitItself) {
  write("earlier.csv",
        "stamp,linear_x,angular_z,unit_anchor,unit_walk,epoch,bridged\n1,0.5,0,0.02,0.001,7,0\n");
  const OdometrySample read = readOdometryCsv(path("earlier.csv")).front();
  EXPECT_EQ(read.unit->anchor_sigma, 0.02);
  EXPECT_EQ(read.unit->constant_sigma, 0.0);
  EXPECT_EQ(read.epoch, 7U);
}

TEST_F(DatasetTest, OdometryFileKeepsWhatTheOdometrySaysOfItself) {
  std::vector<OdometrySample> written(4);
  for (std::size_t i = 0; i < written.size(); ++i) written[i].stamp = static_cast<Stamp>(i) * 100000001;
  written[1].covariance = TwistCovariance::Random();
  written[1].unit = UnitOfLength{std::nullopt, 0.1 / 3.0};
  written[2].unit = UnitOfLength{0.02, 0.0, 0.1 / 7.0};
  written[2].epoch = 4000000000U;
  written[2].bridged = true;
  written[3].correction.emplace();
  written[3].correction->from = 5;
  written[3].correction->to = 200000002;
  written[3].correction->motion = Eigen::Translation3d(0.1, 0.2, 0.3) *
                                  Eigen::Isometry3d(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()));
  written[3].correction->covariance.setRandom();
  written[3].correction->covariance.diagonal() =
      written[3].correction->covariance.diagonal().cwiseAbs().eval();
  written[3].correction->way = {{100000001, written[3].correction->motion},
                                {150000000, Eigen::Isometry3d(Eigen::Translation3d(1.0 / 3.0, 0.0, -7.0))}};
  writeOdometryCsv(path("odometry.csv"), written);
  const auto read = readOdometryCsv(path("odometry.csv"));
  ASSERT_EQ(read.size(), written.size());
  EXPECT_FALSE(read[0].covariance || read[0].unit || read[0].bridged || read[0].correction);
  EXPECT_EQ(*read[1].covariance, *written[1].covariance);
  EXPECT_FALSE(read[1].unit->anchor_sigma);
  EXPECT_EQ(read[1].unit->walk_sigma, 0.1 / 3.0);
  EXPECT_EQ(read[1].unit->constant_sigma, 0.0);
  EXPECT_EQ(read[2].unit->anchor_sigma, 0.02);
  EXPECT_EQ(read[2].unit->constant_sigma, 0.1 / 7.0);
  EXPECT_EQ(read[2].epoch, written[2].epoch);
  EXPECT_TRUE(read[2].bridged);
  EXPECT_EQ(read[3].correction->from, 5);
  EXPECT_EQ(read[3].correction->to, 200000002);
  EXPECT_EQ(read[3].correction->motion.matrix(), written[3].correction->motion.matrix());
  EXPECT_EQ(read[3].correction->covariance, written[3].correction->covariance);
  ASSERT_EQ(read[3].correction->way.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(read[3].correction->way[i].stamp, written[3].correction->way[i].stamp);
    EXPECT_EQ(read[3].correction->way[i].motion.matrix(), written[3].correction->way[i].motion.matrix());
  }
  write("half.csv", "stamp,linear_x,angular_z,cov_11\n0,0,0,1\n");
  EXPECT_NE(complaint([&] { readOdometryCsv(path("half.csv")); }).find("cov_12"), std::string::npos);
}

TEST_F(DatasetTest, RecorderFolderTakesStampsFromItsIndexOrFromTheNames) {
  fs::create_directories(folder_ / "images");
  for (const char* name : {"1669759744666", "1669759744766", "1669759744866"}) {
    cv::imwrite((folder_ / "images" / (std::string(name) + ".jpeg")).string(),
                cv::Mat(8, 8, CV_8UC1, cv::Scalar(9)));
  }
  EXPECT_EQ(RecorderFolder(folder_.string()).imageCount(), 3U) << "without an index the names tell the time";
  write("data_image.txt",
        "1669759744766,images/1669759744766.jpeg\n1669759744666,images/1669759744666.jpeg\n"
        "1669759744766,images/1669759744866.jpeg\n1669759744999,images/missing.jpeg\n");
  RecorderFolder recorder(folder_.string());
  EXPECT_EQ(recorder.imageCount(), 3U) << "the repeated stamp is left out";
  const auto first = recorder.next();
  const auto second = recorder.next();
  const auto third = recorder.next();
  EXPECT_EQ(std::get<RecordedImage>(*first).stamp, 1669759744666 * 1000000);
  EXPECT_EQ(std::get<RecordedImage>(*second).stamp, 1669759744766 * 1000000);
  EXPECT_FALSE(std::get<RecordedImage>(*second).decode().empty());
  EXPECT_TRUE(decodeNow(std::get<RecordedImage>(*third)).image.empty())
      << "a missing file is a corrupt image, not the end";
  EXPECT_FALSE(recorder.next().has_value());
}

TEST_F(DatasetTest, RecorderTimesThatMayBeSecondsAreNamed) {
  fs::create_directories(folder_ / "images");
  for (const char* digits : {"", "000"}) {
    write("data_image.txt", std::string("1600000000") + digits + ",images/a.jpeg\n");
    std::string remarks;
    for (const std::string& remark : RecorderFolder(folder_.string()).remarks()) remarks += remark;
    EXPECT_EQ(remarks.find("time of 10 digits, taken as milliseconds") != std::string::npos, *digits == '\0');
  }
}

TEST_F(DatasetTest, RecorderFolderTurnsImagesThatWereStoredUnrotated) {
  fs::create_directories(folder_ / "images");
  cv::Mat stored(8, 16, CV_8UC1, cv::Scalar(10));
  stored(cv::Rect(0, 0, 4, 4)) = 200;  // top left
  cv::imwrite((folder_ / "images/1669759744666.png").string(), stored);
  const auto bright_corner = [&](int rotate) {
    RecorderFolder recorder(folder_.string(), rotate);
    const cv::Mat image = std::get<RecordedImage>(*recorder.next()).decode();
    EXPECT_EQ(image.size(), rotate % 180 == 0 ? cv::Size(16, 8) : cv::Size(8, 16));
    return std::string(image.at<uchar>(0, 0) == 200                             ? "top left"
                       : image.at<uchar>(0, image.cols - 1) == 200              ? "top right"
                       : image.at<uchar>(image.rows - 1, 0) == 200              ? "bottom left"
                       : image.at<uchar>(image.rows - 1, image.cols - 1) == 200 ? "bottom right"
                                                                                : "none");
  };
  EXPECT_EQ(bright_corner(0), "top left");
  EXPECT_EQ(bright_corner(90), "top right");
  EXPECT_EQ(bright_corner(180), "bottom right");
  EXPECT_EQ(bright_corner(270), "bottom left");
  EXPECT_NE(complaint([&] { RecorderFolder(folder_.string(), 45); }).find("0, 90, 180 or 270"),
            std::string::npos);
}

TEST_F(DatasetTest, RecorderNamesInNanosecondsAndFaultyIndexes) {
  fs::create_directories(folder_ / "images");
  cv::imwrite((folder_ / "images/1669759744666123456.jpg").string(), cv::Mat(8, 8, CV_8UC1, cv::Scalar(9)));
  RecorderFolder recorder(folder_.string());
  EXPECT_EQ(std::get<RecordedImage>(*recorder.next()).stamp, 1669759744666123456);
  write("data_image.txt", "soon,images/1.jpeg\n");
  EXPECT_NE(complaint([&] { RecorderFolder(folder_.string()); }).find("data_image.txt:1"), std::string::npos);
  write("data_image.txt", "1669759744666,images/missing.jpeg\n1669759744666,images/there.jpeg\n16697597");
  cv::imwrite((folder_ / "images/there.jpeg").string(), cv::Mat(8, 8, CV_8UC1, cv::Scalar(9)));
  RecorderFolder cut_off(folder_.string());
  EXPECT_EQ(cut_off.imageCount(), 1U);
  EXPECT_FALSE(std::get<RecordedImage>(*cut_off.next()).decode().empty());
}

TEST_F(DatasetTest, FaultyOdometryFilesAreNamed) {
  write("a.csv", "stamp,speed\n0,1\n");
  EXPECT_NE(complaint([&] { readOdometryCsv(path("a.csv")); }).find("no column named linear_x"),
            std::string::npos);
  write("b.csv", "stamp,linear_x,angular_z\n0,1,0\n1,nan,0\n");
  EXPECT_NE(complaint([&] { readOdometryCsv(path("b.csv")); }).find("b.csv:3: column linear_x"),
            std::string::npos);
  write("c.csv", "stamp,linear_x,angular_z\n1,1,0\n1,1,0\n");
  EXPECT_NE(complaint([&] { readOdometryCsv(path("c.csv")); }).find("c.csv:3: stamps must rise"),
            std::string::npos);
  write("d.csv", "stamp,linear_x,angular_z,r11,r12\n1,1,0,1,0\n");
  EXPECT_NE(complaint([&] { readOdometryCsv(path("d.csv")); }).find("no column named r13"),
            std::string::npos);
}

TEST_F(DatasetTest, OdometryComesBackToTheLastBitAndNanosecond) {
  std::vector<OdometrySample> samples(3);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double number = static_cast<double>(i);
    samples[i].stamp = 1669759744666123457 + static_cast<Stamp>(i) * 100000001;
    samples[i].speed = number / 3.0;
    samples[i].yaw_rate = -0.1 * number;
    samples[i].pose =
        Eigen::Translation3d(0.1 * number, 1.0 / 3.0, -7e-9) *
        Eigen::Isometry3d(Eigen::AngleAxisd(0.3 * number, Eigen::Vector3d(1, 2, 3).normalized()));
  }
  for (const bool with_poses : {true, false}) {
    if (!with_poses) samples[1].pose.reset();
    writeOdometryCsv(path("odometry.csv"), samples);
    const auto back = readOdometryCsv(path("odometry.csv"));
    ASSERT_EQ(back.size(), samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      EXPECT_EQ(back[i].stamp, samples[i].stamp);
      EXPECT_EQ(back[i].speed, samples[i].speed);
      EXPECT_EQ(back[i].yaw_rate, samples[i].yaw_rate);
      ASSERT_EQ(back[i].pose.has_value(), with_poses);
      if (with_poses) {
        EXPECT_EQ(back[i].pose->matrix(), samples[i].pose->matrix());
      }
    }
  }
}

TEST_F(DatasetTest, KittiPosesComeBackToTheLastBit) {
  std::vector<StampedPose3> trajectory(3);
  for (int i = 0; i < 3; ++i) {
    trajectory[static_cast<std::size_t>(i)].pose =
        Eigen::Translation3d(0.1 * i, 1.0 / 3.0, -7e-9) *
        Eigen::AngleAxisd(0.3 * i, Eigen::Vector3d(1, 2, 3).normalized());
  }
  writeKitti(path("poses.txt"), trajectory);
  const auto back = readKittiPoses(path("poses.txt"));
  ASSERT_EQ(back.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(back[i].matrix(), trajectory[i].pose.matrix());
  write("short.txt", "1 0 0 0 0 1 0 0 0 0 1\n");
  EXPECT_NE(complaint([&] { readKittiPoses(path("short.txt")); }).find("short.txt:1"), std::string::npos);
}

TEST(Stretches, BeginWhereTimeDoesNotRise) {
  std::vector<StampedPose3> trajectory(6);
  const Stamp stamps[] = {5, 6, 6, 7, 2, 9};
  for (std::size_t i = 0; i < 6; ++i) trajectory[i].stamp = stamps[i];
  const auto stretches = stretchesOf(trajectory);
  ASSERT_EQ(stretches.size(), 3U);
  EXPECT_EQ(stretches[0].size(), 2U);
  EXPECT_EQ(stretches[1].front().stamp, 6);
  EXPECT_EQ(stretches[2].back().stamp, 9);
  EXPECT_EQ(stretchesOf(std::vector<StampedPose3>{}).size(), 1U) << "a file is written all the same";
  EXPECT_EQ(stretchName("run.v1/final.tum", 0), "run.v1/final.tum");
  EXPECT_EQ(stretchName("run.v1/final.tum", 2), "run.v1/final_3.tum");
}

TEST(FormatStamp, KeepsEveryNanosecond) {
  EXPECT_EQ(formatStamp(1669759744666123457), "1669759744.666123457");
  EXPECT_EQ(formatStamp(5), "0.000000005");
  EXPECT_EQ(formatStamp(-1500000000), "-1.500000000");
}

TEST(ParseStamp, IsTheInverseAndTakesEveryWayToWriteANumber) {
  for (const Stamp stamp : {Stamp{1669759744666123457}, Stamp{5}, Stamp{0}, Stamp{-1500000000}}) {
    EXPECT_EQ(parseStamp(formatStamp(stamp)), stamp);
  }
  EXPECT_EQ(parseStamp("1.0367e-01"), 103670000);
  for (const char* latest : {"9e9", "9000000000", "8999999999.9999999999"}) {
    ASSERT_TRUE(parseStamp(latest)) << latest;
    EXPECT_EQ(parseStamp(formatStamp(*parseStamp(latest))), parseStamp(latest)) << latest;
  }
  EXPECT_FALSE(parseStamp("9000000000.000000001"));
  EXPECT_EQ(parseStamp("0.10367000000000001"), 103670000);
  EXPECT_EQ(parseStamp("0.9999999996"), 1000000000);
  EXPECT_EQ(parseStamp("17"), 17000000000);
  for (const char* text : {"", "-", "soon", "1.2.3", "nan", "1e300"}) {
    EXPECT_FALSE(parseStamp(text).has_value()) << text;
  }
}

}  // namespace
}  // namespace ratslam
