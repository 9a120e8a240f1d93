// Folders as people have them: names without zeros, files of foreign systems, missing images, clocks set back.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "ratslam/dataset/clock.h"
#include "ratslam/dataset/image_folder.h"
#include "ratslam/dataset/kitti_folder.h"
#include "ratslam/dataset/odometry_file.h"
#include "ratslam/dataset/recorder_folder.h"
#include "ratslam/dataset/registry.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;

class FolderFormsTest : public ::testing::Test {
 protected:
  FolderFormsTest()
      : folder_(fs::temp_directory_path() /
                (std::string("folder_forms_") +
                 ::testing::UnitTest::GetInstance()->current_test_info()->name())) {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "image_0");
  }
  ~FolderFormsTest() override { fs::remove_all(folder_); }

  void write(const std::string& name, const std::string& content) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << content;
  }
  void writeImage(const std::string& name) const {
    fs::create_directories((folder_ / name).parent_path());
    cv::imwrite((folder_ / name).string(), cv::Mat(48, 64, CV_8UC1, cv::Scalar(9)));
  }
  static std::vector<Stamp> stampsOf(Recording&& recording) {
    std::vector<Stamp> stamps;
    while (auto item = recording.next()) stamps.push_back(std::get<RecordedImage>(*item).stamp);
    return stamps;
  }
  template <class Action>
  static void expectComplaint(Action action, const std::vector<std::string>& parts) {
    try {
      action();
      ADD_FAILURE() << "nothing was said; expected: " << parts.front();
    } catch (const std::exception& error) {
      for (const std::string& part : parts) {
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
            << error.what() << "\nlacks " << part;
      }
    }
  }

  fs::path folder_;
};

TEST_F(FolderFormsTest, ImagesComeInTheOrderOfTheirNumbers) {
  for (const char* name : {"10.png", "9.PNG", "1.Jpg", "._1.jpg", "08.png", "notes.txt"}) {
    write(std::string("image_0/") + name, "");
  }
  fs::create_directories(folder_ / "image_0/folder.png");
  std::vector<std::string> names;
  for (const std::string& path : listImages((folder_ / "image_0").string()))
    names.push_back(fs::path(path).filename());
  EXPECT_EQ(names, (std::vector<std::string>{"1.Jpg", "08.png", "9.PNG", "10.png"}));
  EXPECT_TRUE(naturallyBefore("a1", "a-1"));
  EXPECT_TRUE(naturallyBefore("a01", "a1"));
  EXPECT_FALSE(naturallyBefore("a1", "a1"));
}

TEST_F(FolderFormsTest, EachImageGetsTheTimeThatItsNumberSays) {
  using Rows = std::vector<std::size_t>;
  const auto rows = [](const std::vector<std::string>& images, std::size_t count) {
    return timesOf(images, count, "times.txt");
  };
  EXPECT_EQ(rows({"a.png", "b.png"}, 2), (Rows{0, 1}));
  EXPECT_EQ(rows({"000000.png", "000001.png", "000003.png"}, 4), (Rows{0, 1, 3}));
  EXPECT_EQ(rows({"0.png", "1.png"}, 9), (Rows{0, 1})) << "the last ones may be missing";
  EXPECT_EQ(rows({"1.png", "3.png"}, 3), (Rows{0, 2}));
  EXPECT_EQ(rows({"frame107.png", "frame109.png"}, 3), (Rows{0, 2}));
  expectComplaint([&] { rows({"a.png", "b.png"}, 3); }, {"times.txt: 3 times for 2 images", "do not tell"});
  expectComplaint([&] { rows({"5.png", "900.png"}, 7); }, {"7 times for 2 images", "numbered 5 to 900"});
  expectComplaint([&] { rows({"0.png", "1.png"}, 1); }, {"1 times for 2 images"});
}

TEST_F(FolderFormsTest, TimesThatNoRecordingHasAreNamed) {
  for (int i = 0; i < 3; ++i) writeImage("image_0/" + std::to_string(i) + ".png");
  const auto refused = [&](const std::string& times, const std::string& words) {
    write("times.txt", times);
    expectComplaint([&] { KittiFolder{folder_.string()}; }, {"times.txt:", words});
  };
  refused("0\n0\n0\n", ": only 0 of 3 times lie after the one before");
  refused("2\n1\n0\n", ": only 0 of 3 times lie after the one before");
  refused("0\n1\n1e300\n", ":3: '1e300' lies outside 0 to 2^32 s");
  refused("-1\n0\n1\n", ":1: '-1' lies outside");
  refused("0\n0,5\n1\n", ":2: '0,5' is not a time in seconds; write decimals with points");
  refused("0\nnan\n1\n", ":2: 'nan' is not a time");
  refused("0\n0x10\n17\n", ":2: '0x10' is not a time");
}

TEST_F(FolderFormsTest, AFewTimesThatDoNotRiseAreLeftToTheImageStage) {
  for (int i = 0; i < 5; ++i) writeImage("image_0/" + std::to_string(i) + ".png");
  write("times.txt", "0\n0.2\n0.1\n0.3\n0.4\n");
  KittiFolder folder(folder_.string());
  std::vector<Stamp> stamps;
  while (const auto item = folder.next()) stamps.push_back(std::get<RecordedImage>(*item).stamp);
  EXPECT_EQ(stamps, (std::vector<Stamp>{0, 200000000, 100000000, 300000000, 400000000}));
}

TEST_F(FolderFormsTest, TheCameraIsFoundWhereverItStandsAndReadOnlyWhenAskedFor) {
  writeImage("image_0/0.png");
  writeImage("image_2/0.png");
  write("times.txt",
        "\xEF\xBB\xBF"
        "0.0\r\n");
  for (const char* form :
       {"# ours\nP0: ", "P1: 9 9\nP2: 70 0 31 0 0 71 23 0 0 0 1 0\nP0: ", "calib_time: 9-Jan\nP_rect_00: "}) {
    write("calib.txt", std::string(form) + "50 0 31 0 0 51 23 0 0 0 1 0\n");
    const auto camera = KittiFolder(folder_.string()).camera();
    ASSERT_TRUE(camera.has_value()) << form;
    EXPECT_EQ(camera->fy, 51.0);
    EXPECT_EQ(camera->width, 64);
    EXPECT_FALSE(camera->doubt().has_value());
  }
  write("calib.txt", "P0: 50 0 31 0 0 51 23 0 0 0 1 0\nP2: 70 0 31 0 0 71 23 0 0 0 1 0\n");
  EXPECT_EQ(KittiFolder(folder_.string(), "image_2").camera()->fx, 70.0);
  EXPECT_EQ(KittiFolder(folder_.string(), "image_2/").camera()->fx, 70.0) << "as a shell completes it";
  write("calib.txt", "P0: 100 0 62 0 0 102 46 0 0 0 1 0\n");
  EXPECT_NE(KittiFolder(folder_.string()).camera()->doubt().value().find("(62, 46)"), std::string::npos);
  KittiFolder folder(folder_.string());
  const std::string p0 = "P0: 50 0 31 0 0 51 23 0 0 0 1 0\n";
  for (const auto& [content, said] : std::vector<std::pair<std::string, std::string>>{
           {"P1: 9 9\n", "calib.txt: no line 'P0:' with the 12 numbers"},
           {"# ours\nP0: 50 0\n", "calib.txt:2: P0: it ends too early"},
           {"P0: 50 0 nan 0 0 51 23 0 0 0 1 0\n", "calib.txt:1: P0: 'nan' is not a number"},
           {"P0: 50, 0, 31, 0, 0, 51, 23, 0, 0, 0, 1, 0\n", "calib.txt:1: P0: '50,' is not a number"},
           {"P0: 50 0 31 0 0 51 23 0 0 0 1 0 7\n", "calib.txt:1: P0: '7' is one too many"},
           {p0 + "P0: 51 0 31 0 0 51 23 0 0 0 1 0\n", "calib.txt:2: P0 is given twice"}}) {
    write("calib.txt", content);
    expectComplaint([&] { folder.camera(); }, {said});
  }
  write("calib.txt", p0 + p0);
  EXPECT_EQ(folder.camera()->fx, 50.0) << "the same once more is no contradiction";
  write("calib.txt", "P0: 1e-310 0 31 0 0 51 23 0 0 0 1 0\n");
  expectComplaint([&] { folder.camera(); }, {"calib.txt: P0", "camera fx"});
}

TEST_F(FolderFormsTest, NumbersOfARecorderTellTheirUnit) {
  for (const char* name : {"1600000000000123", "1600000000100123"})
    writeImage(std::string("images/") + name + ".JPG");
  write("images/._1600000000000123.JPG", "");
  EXPECT_EQ(stampsOf(RecorderFolder(folder_.string())),
            (std::vector<Stamp>{1600000000000123000, 1600000000100123000}));
  write("data_image.txt",
        "\xEF\xBB\xBF"
        " 1600000000000 , images/a.jpeg\r\n1600000000100000000,images/b.jpeg\r\n");
  EXPECT_EQ(stampsOf(RecorderFolder(folder_.string())),
            (std::vector<Stamp>{1600000000000000000, 1600000000100000000}));
  write("data_image.txt", "9999999999998,a.png\n99999999999999999999,b.png\n");
  expectComplaint([&] { RecorderFolder{folder_.string()}; }, {"data_image.txt:1: '9999999999998,a.png'"});
  for (const char* name : {"../other.jpeg", "/etc/passwd", "images/../../x.jpeg"}) {
    write("data_image.txt", std::string("1600000000000,") + name + "\n");
    expectComplaint([&] { RecorderFolder{folder_.string()}; }, {"data_image.txt:1", "does not lie within"});
  }
}

TEST_F(FolderFormsTest, PathsOfARecorderThatNoFileSystemHasAreLeftOutInAShortLine) {
  write("data_image.txt", "1000," + std::string(100000, 'a') + ".jpeg\n1000," + std::string(250, 'b') + "/" +
                              std::string(4, 'c') + "\n1000,b.jpeg\n");
  RecorderFolder recorder(folder_.string());
  EXPECT_EQ(recorder.imageCount(), 1U);
  ASSERT_EQ(recorder.remarks().size(), 2U);
  for (const std::string& remark : recorder.remarks()) EXPECT_LT(remark.size(), 300U);
}

TEST_F(FolderFormsTest, AClockThatWasSetBackIsNamedAndSingleLateLinesAreSorted) {
  std::string lines;
  for (int i = 0; i < 40; ++i) {
    lines += std::to_string(1600000000000 + 100 * i - (i < 25 ? 0 : 1150)) + ",images/" + std::to_string(i) +
             ".jpeg\n";
  }
  write("data_image.txt", lines);
  expectComplaint([&] { RecorderFolder{folder_.string()}; },
                  {"data_image.txt", "set back by 1.050000000 s before the image of 1600000001350 ms"});
  const std::vector<std::vector<int>> orders = {
      {0, 1, 3, 2, 4, 5, 6, 7}, {0, 3, 1, 2, 4, 5, 6, 7}, {7, 2, 5, 1, 6, 0, 4, 3}, {0, 1, 2, 3, 4, 5, 6, 7}};
  for (const auto& order : orders) {
    std::vector<std::pair<Stamp, std::string>> images;
    for (const int i : order) images.emplace_back(100 * i, std::to_string(i));
    EXPECT_FALSE(clockSetBack(images).has_value());
  }
}

TEST_F(FolderFormsTest, FoldersOfBagsAndBagsOfAnotherRosAreNamed) {
  fs::remove_all(folder_ / "image_0");
  fs::remove(folder_ / "times.txt");
  write("drive_1.bag", "");
  write("drive_0.bag", "");
  expectComplaint([&] { folderRecordings().open(folder_.string(), {}); },
                  {"bags lie in it", "name one of them", "drive_0.bag"});
  write("metadata.yaml", "rosbag2_bagfile_information:\n");
  expectComplaint([&] { folderRecordings().open(folder_.string(), {}); },
                  {"a bag of ROS 2", "rosbags-convert"});
}

TEST_F(FolderFormsTest, TheRegistryOpensWhatItsKindsRecogniseAndSaysWhatAFolderIsInstead) {
  const auto open = [&](const RecordingOptions& options) {
    return folderRecordings().open(folder_.string(), options);
  };
  fs::remove(folder_ / "image_0");
  expectComplaint([&] { open({}); },
                  {"neither a KITTI sequence (image_0/, times.txt) nor a recorder's folder"});
  writeImage("image_2/0.png");
  write("times.txt", "0\n");
  expectComplaint([&] { open({}); }, {"its images in image_2/ are read with --image-folder image_2"});
  RecordingOptions options;
  options.image_folder = "image_2";
  EXPECT_EQ(open(options)->imageCount(), 1U);
  options.rotate_deg = 90;
  expectComplaint([&] { open(options); }, {"--rotate 90 is for a recorder's folder"});
  options = {};
  options.with_odometry = true;
  write("data_image.txt", "1600000000000,image_2/0.png\n");
  expectComplaint([&] { open(options); }, {"a folder has no odometry topic"});
  EXPECT_EQ(open({})->imageCount(), 1U);
  fs::remove(folder_ / "data_image.txt");
  fs::rename(folder_ / "image_2/0.png", folder_ / "0.png");
  fs::remove(folder_ / "image_2");
  expectComplaint([&] { open({}); }, {"--image-folder ."});
  fs::rename(folder_ / "times.txt", folder_ / "times.later");
  expectComplaint([&] { open({}); }, {"images lie in it itself", "times.txt", "--image-folder ."});
  fs::rename(folder_ / "times.later", folder_ / "times.txt");
  options = {};
  options.image_folder = ".";
  EXPECT_EQ(open(options)->imageCount(), 1U);

  class Nothing : public Recording {
   public:
    std::optional<RecordedItem> next() override { return std::nullopt; }
    std::size_t imageCount() const override { return 0; }
  };
  RecordingRegistry registry = folderRecordings();
  registry.add({"a file of nothing",
                [](const std::string& path, const RecordingOptions&) { return path == "nothing"; },
                [](const std::string&, const RecordingOptions&) { return std::make_unique<Nothing>(); }});
  EXPECT_EQ(registry.open("nothing", {})->imageCount(), 0U) << "another form is one class and one line";
  expectComplaint([&] { registry.open(folder_.string() + "/nowhere", {}); },
                  {"nowhere", "no such file or folder"});
}

TEST_F(FolderFormsTest, WordsOfACsvFileMayBeQuoted) {
  write("o.csv", "\"frame\", \"stamp\" ,\"linear_x\",\"angular_z\"\n0,\"0\",1.5,0\n1,0.1,\"1.5\",0.2\n");
  const auto samples = readOdometryCsv((folder_ / "o.csv").string());
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(samples[1].speed, 1.5);
  EXPECT_EQ(samples[1].yaw_rate, 0.2);
}

TEST_F(FolderFormsTest, OdometryOfARunIsReadAgainWhateverCameWithIt) {
  OdometrySample sample;
  sample.speed = 1.0;
  sample.sideways = -0.3;
  sample.covariance = TwistCovariance::Constant(std::numeric_limits<double>::infinity());
  (*sample.covariance)(5, 5) = std::numeric_limits<double>::quiet_NaN();
  const std::string path = (folder_ / "o.csv").string();
  writeOdometryCsv(path, {sample});
  const OdometrySample back = readOdometryCsv(path).at(0);
  EXPECT_EQ(back.sideways, -0.3);
  EXPECT_EQ((*back.covariance)(0, 3), std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan((*back.covariance)(5, 5)));
}

TEST_F(FolderFormsTest, OdometryThatIsNoneIsNamed) {
  const auto refused = [&](const std::string& content, const std::vector<std::string>& words) {
    write("o.csv", content);
    expectComplaint([&] { readOdometryCsv((folder_ / "o.csv").string()); }, words);
  };
  const std::string head = "frame,stamp,linear_x,angular_z\n";
  refused("", {"o.csv: is empty"});
  refused(head, {"o.csv: names columns, but holds no odometry"});
  refused("frame,stamp,linear_x,angular_z,linear_x\n0,0,1,1,2\n",
          {"o.csv:1: names the column linear_x twice"});
  for (const char* named :
       {"Frame,Stamp,Linear_X", "stamp [s],linear_x [m/s]", "0,0.1,1.5,0", "0.1 0 0 0 0 0 0 1"}) {
    refused(std::string(named) + "\n0,0,1,1\n", {"o.csv:1: has no column named stamp", named});
  }
  refused("frame;stamp;linear_x;angular_z\n0;0;1;1\n",
          {"o.csv:1: has no column named stamp; columns are parted"});
  refused("frame\tstamp\tlinear_x\tangular_z\n0\t0\t1\t1\n",
          {"o.csv:1: has no column named stamp; columns are parted"});
  refused(head + "0,9999999999,1,0\n", {"o.csv:2: column stamp: '9999999999' is not a time in seconds"});
  refused(head + "0,1600000000000000000,1,0\n", {"o.csv:2: column stamp", "time in seconds"});
  refused(head + "0,0,1,5,0,1\n", {"o.csv:2: 6 values under 4 columns; if decimals are written with commas"});
  refused(head + "0,0,inf,0\n", {"o.csv:2: column linear_x: 'inf' is not a finite number"});
  refused(
      "stamp,linear_x,angular_z,r11,r12,r13,x,r21,r22,r23,y,r31,r32,r33,z\n0,0,0,2,0,0,0,0,2,0,0,0,0,2,0\n",
      {"o.csv:2: r11 to r33 are no rotation matrix"});
  refused("stamp,linear_x,angular_z,x,z\n0,1,0,9,9,9\n",
          {"6 values under 5 columns"});  // x and z are of others
  refused("stamp,linear_x,angular_z,r12,x\n0,1,0,0,0\n", {"o.csv:1: has no column named r11"});
  refused("stamp,linear_x,angular_z,bridged\n0,1,0,1\n", {"o.csv:1: has no column named unit_anchor"});
  refused("stamp,linear_x,angular_z,correction_from,correction_to,correction_way\n0,1,0,0,1,\n",
          {"o.csv:1: has no column named correction_r11"});
  write("o.csv", "\xEF\xBB\xBF stamp , linear_x,angular_z \r\n 0.5 , 1,2\r\n\r\n");
  const auto samples = readOdometryCsv((folder_ / "o.csv").string());
  ASSERT_EQ(samples.size(), 1U);
  EXPECT_EQ(samples[0].stamp, 500000000);
  EXPECT_EQ(samples[0].yaw_rate, 2.0);
}

}  // namespace
}  // namespace ratslam
