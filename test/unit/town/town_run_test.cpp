#include "town/town_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "ratslam/common/angles.h"
#include "town/sensors.h"
#include "town_test_support.h"

namespace ratslam {
namespace {

namespace fs = std::filesystem;

/// Keeps frames in memory.
class MemorySink : public TownSink {
 public:
  void add(const TownFrame& frame) override { frames.push_back(frame); }
  void finish() override { ++finished; }
  std::vector<TownFrame> frames;
  int finished = 0;
};

TownOptions smallOptions(int frames) {
  TownOptions options;
  options.out = "unused";
  options.size = "160x48";
  options.frames = frames;
  return options;
}

MemorySink run(const TownOptions& options) {
  MemorySink sink;
  runTown(options, sink, {});
  return sink;
}

std::vector<std::string> linesOf(const std::string& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<double> numbersOf(std::string line) {
  std::replace(line.begin(), line.end(), ',', ' ');
  std::istringstream in(line);
  std::vector<double> numbers;
  for (double value = 0.0; in >> value;) numbers.push_back(value);
  return numbers;
}

TEST(TownRun, TheLightChangesWhenItIsTold) {
  TownOptions options = smallOptions(4);
  const MemorySink plain = run(options);
  options.other_light_after = 0.15;
  const MemorySink evening = run(options);
  EXPECT_EQ(cv::norm(plain.frames[1].image, evening.frames[1].image, cv::NORM_INF), 0.0);
  EXPECT_LT(cv::mean(evening.frames[2].image)[0], 0.8 * cv::mean(plain.frames[2].image)[0]);
}

TEST(TownRun, DisturbancesAreDeterministicAndChangeOnlyTheImages) {
  TownOptions options = smallOptions(4);
  const MemorySink plain = run(options);
  options.exposure = true;
  options.noise = 4.0;
  options.moving_cars = 40;
  const MemorySink once = run(options);
  options.threads = 2;
  const MemorySink again = run(options);
  ASSERT_EQ(once.frames.size(), 4U);
  EXPECT_EQ(once.finished, 1);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(equalBytes(once.frames[i].image, again.frames[i].image));
    EXPECT_FALSE(equalBytes(once.frames[i].image, plain.frames[i].image));
    EXPECT_TRUE(once.frames[i].T_world_camera.isApprox(plain.frames[i].T_world_camera, 0.0));
  }
}

TEST(TownRun, EndsEarlyWhenTold) {
  MemorySink sink;
  const TownSummary summary = runTown(smallOptions(50), sink, [](int done, int) { return done < 3; });
  EXPECT_EQ(summary.frames, 3);
  EXPECT_EQ(sink.frames.size(), 3U);
  EXPECT_EQ(sink.finished, 1);
}

/// A drive straight ahead from a place that is not the origin, at the given times.
TownOptions recordedOptions(const TemporaryFolder& folder, const std::vector<double>& times) {
  std::ofstream poses(folder / "poses.txt");
  std::ofstream stamps(folder / "times.txt");
  for (std::size_t i = 0; i < times.size(); ++i) {
    poses << "1 0 0 300 0 1 0 -20 0 0 1 " << 500.0 + 0.5 * static_cast<double>(i) << "\n";
    stamps << times[i] << "\n";
  }
  TownOptions options = smallOptions(-1);
  options.trajectory = folder / "poses.txt";
  options.times = folder / "times.txt";
  return options;
}

TEST(TownRun, GpsComesOnceASecondAfterAGapToo) {
  const TemporaryFolder folder;
  const MemorySink sink = run(recordedOptions(folder, {0.0, 0.5, 1.0, 6.1, 6.5, 7.0, 7.2, 7.6, 8.3}));
  std::vector<Stamp> fixes;  // [ms]
  for (const TownFrame& frame : sink.frames)
    if (frame.gps) fixes.push_back(frame.stamp / 1000000);
  EXPECT_EQ(fixes, (std::vector<Stamp>{0, 1000, 6100, 7200, 8300}));
}

TEST(TownRun, TheFirstPoseLiesAtTheOrigin) {
  const TemporaryFolder folder;
  const TownOptions options = recordedOptions(folder, {0.0, 1.0});
  const MemorySink sink = run(options);
  ASSERT_TRUE(sink.frames[0].gps);
  EXPECT_NEAR(sink.frames[0].gps->latitude, options.origin[0], 1e-10);
  EXPECT_NEAR(sink.frames[0].gps->longitude, options.origin[1], 1e-10);
  EXPECT_NEAR(sink.frames[0].gps->altitude, options.origin[2], 1e-6);
  EXPECT_NEAR(sink.frames[1].gps->latitude, options.origin[0] + 0.5 / 111000.0, 1e-7);
}

TEST(Sensors, NoiseHasTheAskedDeviationAndNoMean) {
  const cv::Mat grey(200, 200, CV_32F, cv::Scalar(120.0));
  cv::Mat deviation;
  cv::Mat mean;
  cv::meanStdDev(expose(grey, {}, 6.0, 1), mean, deviation);
  EXPECT_NEAR(mean.at<double>(0), 120.0, 0.15);
  EXPECT_NEAR(deviation.at<double>(0), 6.0, 0.15);
  EXPECT_FALSE(equalBytes(expose(grey, {}, 6.0, 1), expose(grey, {}, 6.0, 2)));
  EXPECT_EQ(expose(grey, {3.0, 0.0}, 0.0, 1).at<std::uint8_t>(0, 0), 255);
}

TEST(Sensors, ExposureDriftsAndJumpsWithinLimits) {
  double largest_step = 0.0;
  double before = exposureAt(0.0, 3).gain;
  for (int frame = 0; frame < 3000; ++frame) {
    const Exposure exposure = exposureAt(0.1 * frame, 3);
    EXPECT_GT(exposure.gain, 0.5);
    EXPECT_LT(exposure.gain, 1.6);
    largest_step = std::max(largest_step, std::abs(exposure.gain - before));
    before = exposure.gain;
  }
  EXPECT_GT(largest_step, 0.05);
}

TEST(Sensors, WheelOdometryAddsUpToTheDrive) {
  TownOptions options = smallOptions(200);
  options.wheel_noise = {0.0, 0.0, 0.0};
  const Drive drive = planTownDrive(200);
  const DriveSensors sensors(drive, options);
  double x = 0.0;
  double z = 0.0;
  double heading = 0.5 * kPi;  // counter-clockwise from x; the drive starts towards z
  for (std::size_t i = 1; i < drive.poses.size(); ++i) {
    const OdometrySample sample = sensors.wheel(i);
    heading += 0.1 * sample.yaw_rate;
    x += 0.1 * sample.speed * std::cos(heading);
    z += 0.1 * sample.speed * std::sin(heading);
  }
  const Eigen::Isometry3d& end = drive.poses.back().T_world_camera;
  EXPECT_NEAR(wrapAngle(heading - std::atan2(end(2, 2), end(0, 2))), 0.0, 1e-6);
  EXPECT_NEAR(x, end.translation().x(),
              1.0);  // the step lies along the new heading: a fraction of a step a turn
  EXPECT_NEAR(z, end.translation().z(), 1.0);
  options.wheel_noise = {0.05, 0.0, 0.0};
  EXPECT_NEAR(DriveSensors(drive, options).wheel(7).speed, 1.05 * sensors.wheel(7).speed, 1e-9);
}

TEST(Sensors, WheelOdometryErrsAsItsCovarianceSays) {
  TownOptions options = smallOptions(600);
  const Drive drive = planTownDrive(600);
  options.wheel_slip = {0.0, 0.0};
  const DriveSensors exact(drive, options);
  options.wheel_slip = {0.02, 0.5};
  options.wheel_covariance = true;
  const DriveSensors slipping(drive, options);
  double speed = 0.0;
  double turn = 0.0;
  for (std::size_t i = 1; i < drive.poses.size(); ++i) {
    const OdometrySample sample = slipping.wheel(i);
    ASSERT_TRUE(sample.covariance);
    speed += std::pow(sample.speed - exact.wheel(i).speed, 2) / (*sample.covariance)(0, 0);
    turn += std::pow(sample.yaw_rate - exact.wheel(i).yaw_rate, 2) / (*sample.covariance)(5, 5);
  }
  EXPECT_FALSE(exact.wheel(7).covariance);
  const double samples = static_cast<double>(drive.poses.size() - 1);
  EXPECT_NEAR(speed / samples, 1.0, 0.2);  // chi-squared: deviation sqrt(2 / n) = 0.06
  EXPECT_NEAR(turn / samples, 1.0, 0.2);
}

TEST(Sensors, GpsFollowsTheEllipsoid) {
  // A degree of latitude at 45 degrees is 111131.8 m, of longitude 78846.8 m (WGS-84).
  const Eigen::Vector3d origin(45.0, 10.0, 0.0);
  EXPECT_NEAR(geodeticFromEnu(origin, {0.0, 111.1318, 0.0}).x(), 45.001, 1e-8);
  EXPECT_NEAR(geodeticFromEnu(origin, {78.8468, 0.0, 0.0}).y(), 10.001, 1e-8);
  const Eigen::Vector3d up = geodeticFromEnu({-33.0, 151.0, 20.0}, {0.0, 0.0, 35.0});
  EXPECT_NEAR(up.x(), -33.0, 1e-10);
  EXPECT_NEAR(up.y(), 151.0, 1e-10);
  EXPECT_NEAR(up.z(), 55.0, 1e-6);
  // A tangent plane leaves the ellipsoid by d^2/2R.
  EXPECT_NEAR(geodeticFromEnu(origin, {5000.0, 0.0, 0.0}).z(), 5000.0 * 5000.0 / (2.0 * 6388838.0), 0.01);
}

TEST(Sensors, ImuFeelsGravityAndTurns) {
  const Drive drive = planTownDrive(120);
  const DriveSensors sensors(drive, smallOptions(120));
  double turned = 0.0;
  Stamp last = -1;
  for (std::size_t i = 0; i < drive.poses.size(); ++i)
    for (const ImuSample& sample : sensors.imu(i)) {
      EXPECT_EQ(sample.stamp, last < 0 ? 0 : last + 10000000);
      last = sample.stamp;
      EXPECT_NEAR(sample.acceleration.y(), -9.80665, 1e-6);  // the road pushes up, y looks down
      turned += 0.01 * sample.angular_rate.y();
    }
  EXPECT_EQ(last, drive.poses.back().stamp);
  const Eigen::Isometry3d& end = drive.poses.back().T_world_camera;
  EXPECT_NEAR(wrapAngle(turned - std::atan2(end(0, 2), end(2, 2))), 0.0, 1e-3);
}

TEST(Layouts, KittiFolderHoldsTheDrive) {
  TemporaryFolder folder;
  TownOptions options = smallOptions(3);
  options.out = folder / "town";
  options.wheel_noise = {0.0, 0.0, 0.0};
  const auto sink = makeFolderSink(options);
  runTown(options, *sink, {});
  const MemorySink expected = run(options);
  ASSERT_EQ(linesOf(options.out + "/times.txt").size(), 3U);
  ASSERT_EQ(linesOf(options.out + "/poses.txt").size(), 3U);
  EXPECT_EQ(linesOf(options.out + "/odometry.csv").size(), 4U);
  for (std::size_t i = 0; i < 3; ++i) {
    const cv::Mat image =
        cv::imread(options.out + "/image_0/00000" + std::to_string(i) + ".png", cv::IMREAD_UNCHANGED);
    EXPECT_TRUE(equalBytes(image, expected.frames[i].image));
    const std::vector<double> pose = numbersOf(linesOf(options.out + "/poses.txt")[i]);
    ASSERT_EQ(pose.size(), 12U);
    EXPECT_NEAR(pose[11], expected.frames[i].T_world_camera.translation().z(), 1e-9);
  }
  const std::vector<std::string> calibration = linesOf(options.out + "/calib.txt");
  ASSERT_EQ(calibration.size(), 4U);
  const std::vector<double> p0 = numbersOf(calibration[0].substr(3));
  ASSERT_EQ(p0.size(), 12U);
  EXPECT_NEAR(p0[0], 718.856 * 160 / 1241, 1e-9);
  EXPECT_NEAR(p0[6], options.camera().cy, 1e-9);
  EXPECT_NE(complaint([&] { makeFolderSink(options); }).find("exists already"), std::string::npos);
}

TEST(Layouts, RecorderFolderHoldsTheDrive) {
  TemporaryFolder folder;
  TownOptions options = smallOptions(12);
  options.out = folder.path();
  options.layout = "recorder";
  options.distortion = {-0.2, 0.05, 0.0, 0.0, 0.0};
  options.gps_noise = 3.0;
  const auto sink = makeFolderSink(options);
  runTown(options, *sink, {});
  const std::string drive = folder / "20-09-13-12-26-40";
  const std::vector<std::string> images = linesOf(drive + "/data_image.txt");
  ASSERT_EQ(images.size(), 12U);
  EXPECT_EQ(images[1], "1600000000100,images/1600000000100.jpeg");
  for (const std::string& line : images)
    EXPECT_EQ(cv::imread(drive + "/" + line.substr(line.find(',') + 1), cv::IMREAD_GRAYSCALE).cols, 160);
  const std::vector<std::string> gps = linesOf(drive + "/data_gps.txt");
  ASSERT_EQ(gps.size(), 2U);  // once a second
  const std::vector<double> fix = numbersOf(gps[0].substr(0, gps[0].rfind(',')));
  ASSERT_EQ(fix.size(), 7U);
  EXPECT_NEAR(fix[1], options.origin[0], 15.0 / 111000.0);
  EXPECT_NE(fix[1], options.origin[0]);
  EXPECT_EQ(fix[4], 4.53) << "the radius that holds 68 % of fixes of 3 m an axis";
  EXPECT_EQ(linesOf(drive + "/data_imu.txt").size(), 111U);
  EXPECT_EQ(numbersOf(linesOf(drive + "/data_imu.txt")[5]).size(), 7U);
  const std::vector<std::string> truth = linesOf(folder / "truth.tum");
  ASSERT_EQ(truth.size(), 12U);
  EXPECT_EQ(truth[1].substr(0, 14), "1600000000.100");
  EXPECT_EQ(numbersOf(truth[1]).size(), 8U);
  const std::vector<std::string> calibration = linesOf(folder / "calibration.yaml");
  EXPECT_EQ(calibration[0], "image_width: 160");  // as config/calibration/phone_example.yaml
  EXPECT_EQ(calibration[6], "k1: -0.2");
}

TEST(Layouts, NoFileIsOverwritten) {
  for (const std::string name : {"image_0", "times.txt", "calib.txt", "poses.txt", "odometry.csv"}) {
    const TemporaryFolder folder;
    std::ofstream(folder / name) << "mine\n";
    TownOptions options = smallOptions(1);
    options.out = folder.path();
    const std::string said = complaint([&] { makeFolderSink(options); });
    EXPECT_NE(said.find(name + " is not allowed: it exists already"), std::string::npos) << said;
    EXPECT_EQ(linesOf(folder / name), std::vector<std::string>{"mine"});
  }
  for (const std::string name : {"truth.tum", "calibration.yaml"}) {
    const TemporaryFolder folder;
    fs::create_symlink("nowhere", folder / name);  // a file may be written through it
    TownOptions options = smallOptions(1);
    options.out = folder.path();
    options.layout = "recorder";
    options.start = 1700000000.0;
    const std::string said = complaint([&] { makeFolderSink(options); });
    EXPECT_NE(said.find(name + " is not allowed: it exists already"), std::string::npos) << said;
  }
}

TEST(Options, WhatALayoutCannotKeepIsRefused) {
  const TemporaryFolder folder;
  const auto fails = [&](const std::string& out, std::vector<std::string> arguments,
                         const std::string& expected) {
    arguments.insert(arguments.begin(), {"--out", folder / out});
    const std::string said = complaint([&] { makeFolderSink(parseTownOptions(arguments)); });
    EXPECT_NE(said.find(expected), std::string::npos) << said;
    EXPECT_TRUE(fs::is_empty(folder.path()));
  };
  fails("a", {"--distortion=-0.2,0.05,0,0,0"},
        "distortion: value -0.2,0.05,0,0,0 is not allowed: the kitti layout");
  fails("a", {"--gps-noise", "3"}, "gps_noise: value 3 is not allowed: the kitti layout");
  fails("a", {"--origin", "1,2,3"}, "origin: value 1,2,3 is not allowed: the kitti layout");
  fails("a", {"--start", "5"}, "start: value 5 is not allowed: the kitti layout");
  fails("a", {"--layout", "recorder", "--wheel-noise", "0,1,0"},
        "wheel_noise: value 0,1,0 is not allowed: the recorder layout");
  fails("a", {"--layout", "recorder", "--wheel-slip", "0,1", "--wheel-covariance"},
        "wheel_slip: value 0,1 is not allowed: the recorder layout");
  fails("a.bag", {"--layout", "recorder"}, "layout: value recorder is not allowed: --out names a bag");
  EXPECT_NO_THROW(makeFolderSink(parseTownOptions({"--out", folder / "a", "--distortion=0,0,0,0,0"})));
}

TEST(Options, ReadsAllFormsAndNamesWhatIsWrong) {
  const TownOptions options =
      parseTownOptions({"--out", "x", "--moving-cars=3", "--exposure", "--noise", "1.5", "--size", "640x480",
                        "--calibration", "500,501,320,240"});
  EXPECT_EQ(options.moving_cars, 3);
  EXPECT_TRUE(options.exposure);
  EXPECT_EQ(options.camera().height, 480);
  EXPECT_EQ(options.camera().fy, 501.0);
  const auto fails = [](std::vector<std::string> arguments, const std::string& expected) {
    arguments.insert(arguments.begin(), {"--out", "x"});
    const std::string said = complaint([&] { parseTownOptions(arguments); });
    EXPECT_NE(said.find(expected), std::string::npos) << said;
  };
  fails({"--frame", "3"}, "option: value --frame is not allowed: there is no such option");
  fails({"--frames", "many"}, "frames: value many is not allowed: it must be a whole number");
  fails({"--frames", "0"}, "frames: value 0");
  fails({"--frames"}, "frames: value  is not allowed: a value must follow");
  fails({"--noise", "-1"}, "noise: value -1 is not allowed: it must lie within [0, 100]");
  fails({"--noise", "nan"}, "noise: value nan");
  fails({"--size", "640"}, "size: value 640 is not allowed: it must be WIDTHxHEIGHT");
  fails({"--size", "640x480p"}, "size: value 640x480p");
  fails({"--size", "8x8"}, "width: value 8");
  fails({"--calibration", "1,2,3"}, "calibration: value 1,2,3 is not allowed: it must be 4 numbers");
  fails({"--distortion", "0.1"}, "distortion: value 0.1 is not allowed: it must be 5 numbers");
  fails({"--wheel-noise", "0,-1,0"}, "standard deviations must not be negative");
  fails({"--wheel-slip", "0.02"}, "2 numbers");
  fails({"--wheel-covariance"}, "wheel_noise or wheel_slip");
  fails({"--layout", "tum"}, "layout: value tum is not allowed: it must be kitti or recorder");
  fails({"--times", "t.txt"}, "times: value t.txt is not allowed: it needs a trajectory");
  fails({"--origin", "95,0,0"}, "origin: value 95,0,0");
  fails({"--exposure=maybe"}, "exposure: value maybe is not allowed: it must be true or false");
  EXPECT_NE(complaint([] { parseTownOptions({}); }).find("out: value"), std::string::npos);
}

TEST(Options, HelpNamesEveryOption) {
  const std::string help = townUsage();
  TownOptions options;
  options.visitFields([&](std::string key, auto&, const Bounds&, const char*) {
    std::replace(key.begin(), key.end(), '_', '-');
    EXPECT_NE(help.find("  --" + key + " "), std::string::npos) << key;
  });
}

}  // namespace
}  // namespace ratslam
