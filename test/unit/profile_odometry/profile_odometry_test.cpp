#include "ratslam/odometry/profile/profile_odometry.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <opencv2/imgproc.hpp>

namespace ratslam {
namespace {

constexpr Stamp kTenth = 100000000;

/// A band of smooth random columns, 400 wide, seen through a window that starts at `offset`.
cv::Mat scene(int offset, int type = CV_8UC1) {
  cv::Mat wide(60, 400, CV_8UC1);
  std::uint32_t state = 12345;
  int value = 128;
  for (int x = 0; x < wide.cols; ++x) {
    state = state * 1664525U + 1013904223U;
    value = std::min(240, std::max(15, value + static_cast<int>(state >> 24) % 61 - 30));
    wide.col(x).setTo(value);
  }
  const cv::Mat window = wide.colRange(offset, offset + 200);
  cv::Mat result;
  if (type == CV_8UC1) return window;  // keeps the wide image's row stride
  if (type == CV_16UC1) {
    window.convertTo(result, CV_16U, 257.0);
  } else {
    cv::cvtColor(window, result, type == CV_8UC3 ? cv::COLOR_GRAY2BGR : cv::COLOR_GRAY2BGRA);
  }
  return result;
}

ProfileOdometryParams params() {
  ProfileOdometryParams p;
  p.fov_deg = 50.0;
  return p;
}

class Turning : public ::testing::TestWithParam<int> {};

TEST_P(Turning, YawRateIsTheSceneShiftTimesTheAnglePerPixel) {
  const int shift = GetParam();
  ProfileOdometry odometry(params());
  odometry.track(0, scene(100));
  // A car that turns left sees the scene move to the right: its window moves left over the wide image.
  const OdometrySample sample = odometry.track(kTenth, scene(100 - shift));
  EXPECT_NEAR(sample.yaw_rate, shift * degreesToRadians(50.0) / 200.0 / 0.1, 1e-12);
  EXPECT_NEAR(sample.speed, 0.0, 1e-12);
}
INSTANTIATE_TEST_SUITE_P(Shifts, Turning, ::testing::Values(-40, -17, -1, 0, 1, 23, 40));

TEST(ProfileOdometry, EveryPixelFormatGivesTheSameMotion) {
  for (const int type : {CV_8UC3, CV_8UC4, CV_16UC1}) {
    ProfileOdometry grey(params());
    ProfileOdometry other(params());
    grey.track(0, scene(100));
    other.track(0, scene(100, type));
    cv::Mat later = scene(93).clone();
    later.rowRange(0, 20) *= 0.8;
    cv::Mat later_other;
    if (type == CV_16UC1) {
      later.convertTo(later_other, CV_16U, 257.0);
    } else {
      cv::cvtColor(later, later_other, type == CV_8UC3 ? cv::COLOR_GRAY2BGR : cv::COLOR_GRAY2BGRA);
    }
    const OdometrySample a = grey.track(kTenth, later);
    const OdometrySample b = other.track(kTenth, later_other);
    EXPECT_NEAR(a.speed, b.speed, 1e-9);
    EXPECT_GT(a.speed, 0.0);
    EXPECT_DOUBLE_EQ(a.yaw_rate, b.yaw_rate);
  }
}

TEST(ProfileOdometry, SpeedIsBoundedAndTakesTheTrueTime) {
  ProfileOdometryParams p = params();
  p.vtrans_max = 4.0;
  p.vtrans_scaling = 1e6;
  ProfileOdometry odometry(p);
  odometry.track(0, scene(100));
  const OdometrySample sample = odometry.track(2 * kTenth, scene(95) + 2);
  EXPECT_DOUBLE_EQ(sample.speed, 4.0);
  EXPECT_NEAR(sample.yaw_rate, 5 * degreesToRadians(50.0) / 200.0 / 0.2, 1e-12);
}

/// A robot that is parked before a camera that shows nothing.
TEST(ProfileOdometry, PredictsNoEndlessDrive) {
  ProfileOdometryParams p = params();
  p.vtrans_max = 4.0;
  p.vtrans_scaling = 1e6;
  ProfileOdometry odometry(p);
  odometry.track(0, scene(100));
  odometry.track(2 * kTenth, scene(95) + 2);
  OdometrySample sample;
  for (int second = 1; second <= 600; ++second) sample = odometry.bridge(second * 10 * kTenth);
  EXPECT_EQ(sample.speed, 0.0);
  EXPECT_LT(sample.pose->translation().norm(), 4.0 * 32.0);
  EXPECT_GT(sample.pose->translation().norm(), 4.0 * 25.0);
}

TEST(ProfileOdometry, ABlankWallIsNoTurn) {
  ProfileOdometry odometry(params());
  const cv::Mat wall(60, 200, CV_8UC1, cv::Scalar(90));
  odometry.track(0, wall);
  const OdometrySample sample = odometry.track(kTenth, wall);
  EXPECT_EQ(sample.yaw_rate, 0.0);
  EXPECT_EQ(sample.speed, 0.0);
}

TEST(ProfileOdometry, RegionsOutsideTheImageAndChangingSizesAreNamed) {
  const auto complaint = [](const ProfileOdometryParams& p, const cv::Mat& first,
                            const cv::Mat& second) -> std::string {
    try {
      ProfileOdometry odometry(p);
      odometry.track(0, first);
      odometry.track(kTenth, second);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  ProfileOdometryParams wide = params();
  wide.vrot_x_max = 201;
  EXPECT_NE(complaint(wide, scene(0), scene(0)).find("vrot_image_x_max: value 201"), std::string::npos);
  ProfileOdometryParams inverted = params();
  inverted.vtrans_y_min = 50;
  inverted.vtrans_y_max = 20;
  EXPECT_NE(complaint(inverted, scene(0), scene(0)).find("vtrans_image_y_min: value 50"), std::string::npos);
  EXPECT_NE(complaint(params(), scene(0), scene(0).colRange(0, 100)).find("200x60 to 100x60"),
            std::string::npos);
  EXPECT_NE(complaint(params(), cv::Mat(), scene(0)).find("empty"), std::string::npos);
}

}  // namespace
}  // namespace ratslam
