/// The whole odometry on rendered streets: what it must measure, and what it must survive.
#include "ratslam/odometry/orb/orb_odometry.h"

#include <gtest/gtest.h>

#include <cstring>
#include <functional>

#include "ratslam/common/angles.h"
#include "ratslam/odometry/uncertainty.h"
#include "street_scene.h"

namespace ratslam {
namespace {

using test::cameraAt;
using test::kPeriod;
using test::kStep;
using test::smallCamera;
using test::smallParams;
using test::StreetScene;

class OrbOdometryOnAStreet : public testing::Test {
 protected:
  static const StreetScene& scene() {
    static const StreetScene street;
    return street;
  }
  static OrbOdometryParams metric() {
    OrbOdometryParams params = smallParams();
    params.camera_height = StreetScene::kCameraHeight;
    return params;
  }
  /// Feeds images of the poses that `pose_of(frame)` gives; `spoil` may change them first.
  std::vector<OrbResult> drive(
      OrbOdometry& odometry, int frames, const std::function<RigidTransform(int)>& pose_of,
      const std::function<void(int, cv::Mat&)>& spoil = [](int, cv::Mat&) {}) {
    std::vector<OrbResult> results;
    for (int i = 0; i < frames; ++i) {
      cv::Mat image = scene().render(smallCamera(), pose_of(i));
      spoil(i, image);
      results.push_back(odometry.track(stampFromSeconds(kPeriod * next_frame_++), image));
      EXPECT_TRUE(results.back().sample.pose->matrix().allFinite());
      EXPECT_TRUE(results.back().twist.allFinite());
      EXPECT_EQ(whyAbsurd(results.back().covariance), "") << "frame " << i;
    }
    return results;
  }
  static void grainy(int frame, cv::Mat& image) {
    cv::RNG noise(static_cast<std::uint64_t>(frame) + 1);
    cv::Mat grain(image.size(), CV_16SC1);
    noise.fill(grain, cv::RNG::NORMAL, 0, 2.0);
    cv::add(image, grain, image, cv::noArray(), CV_8U);
  }
  static RigidTransform straight(int i) { return cameraAt(0.0, kStep * i); }
  static Eigen::Vector3d place(const OrbResult& result) { return result.sample.pose->translation(); }
  static double travelled(const std::vector<OrbResult>& results, std::size_t from, std::size_t to) {
    return (place(results[to]) - place(results[from])).norm();
  }

  int next_frame_ = 0;
};

TEST_F(OrbOdometryOnAStreet, StartsWhileMovingAndIsMetricByTheRoad) {
  OrbOdometry odometry(smallCamera(), metric());
  const auto results = drive(odometry, 40, straight);
  EXPECT_EQ(results.back().state, OrbState::kTracking);
  EXPECT_EQ(odometry.restarts(), 0);
  EXPECT_NEAR(travelled(results, 10, 39), 29 * kStep, 0.02 * 29 * kStep);
  EXPECT_NEAR(results.back().sample.speed, kStep / kPeriod, 0.05 * kStep / kPeriod);
  EXPECT_NEAR(results.back().sample.yaw_rate, 0.0, 0.01);
  const Eigen::Vector3d path = place(results.back());
  EXPECT_NEAR(path.y(), 0.0, 0.02 * path.x());
  EXPECT_NEAR(path.z(), 0.0, 0.02 * path.x());
}

TEST_F(OrbOdometryOnAStreet, YawIsCounterClockwisePositive) {
  OrbOdometry odometry(smallCamera(), metric());
  const double turn = 0.012;  // to the left, per frame
  const auto results =
      drive(odometry, 30, [&](int i) { return cameraAt(-0.5 * kStep * turn * i * i, kStep * i, turn * i); });
  const Eigen::Vector3d forward = results.back().sample.pose->linear().col(0);
  EXPECT_NEAR(std::atan2(forward.y(), forward.x()), 29 * turn, 0.01);
  EXPECT_NEAR(results.back().sample.yaw_rate, turn / kPeriod, 0.02);
}

TEST_F(OrbOdometryOnAStreet, ACameraOffTheAxleIsCarriedRoundByTheTurn) {
  const double turn_per_frame = 0.012;
  const auto bend = [&](int i) {
    return cameraAt(-0.5 * kStep * turn_per_frame * i * i, kStep * i, turn_per_frame * i);
  };
  OrbOdometry in_the_camera(smallCamera(), metric());
  const auto camera = drive(in_the_camera, 30, bend);
  OrbOdometryParams params = metric();
  params.camera_x = 1.2;
  params.camera_y = -0.3;
  params.camera_z = 1.1;
  OrbOdometry at_the_axle(smallCamera(), params);
  next_frame_ = 0;
  const auto axle = drive(at_the_axle, 30, bend);
  const Eigen::Isometry3d mount(Eigen::Translation3d(1.2, -0.3, 1.1));
  for (std::size_t i = 0; i < camera.size(); ++i) {
    const Eigen::Isometry3d expected = mount * *camera[i].sample.pose * mount.inverse();
    EXPECT_TRUE(axle[i].sample.pose->isApprox(expected, 1e-9)) << i;
    const Eigen::Vector3d turn = camera[i].twist.tail<3>();
    EXPECT_TRUE(axle[i].twist.tail<3>().isApprox(turn, 1e-9));
    EXPECT_NEAR(axle[i].sample.speed, camera[i].twist(0) - turn.cross(mount.translation()).x(), 1e-9);
    EXPECT_NEAR(axle[i].covariance(5, 5), camera[i].covariance(5, 5), 1e-12);
  }
  EXPECT_NEAR(axle.back().sample.speed - camera.back().sample.speed, -0.3 * turn_per_frame / kPeriod, 0.01);
}

TEST(CameraMount, IsGivenBackByItsNumbers) {
  OrbOdometryParams params;
  params.camera_pitch_deg = 12.0;
  params.camera_yaw_deg = -40.0;
  params.camera_roll_deg = 3.0;
  params.camera_x = 0.5;
  OrbOdometryParams found;
  found.setBaseFromCamera(params.baseFromCamera());
  EXPECT_NEAR(found.camera_pitch_deg, 12.0, 1e-9);
  EXPECT_NEAR(found.camera_yaw_deg, -40.0, 1e-9);
  EXPECT_NEAR(found.camera_roll_deg, 3.0, 1e-9);
  EXPECT_EQ(found.camera_x, 0.5);
  // A camera that looks down sees the floor ahead: its axis points forward and down in base_link.
  const Eigen::Vector3d axis = params.baseFromCamera().linear() * Eigen::Vector3d::UnitZ();
  EXPECT_GT(axis.x(), 0.7);
  EXPECT_LT(axis.y(), -0.6);  // to the right
  EXPECT_NEAR(axis.z(), -std::sin(degreesToRadians(12.0)), 1e-9);
}

TEST_F(OrbOdometryOnAStreet, StandingCarDoesNotDrift) {
  OrbOdometry odometry(smallCamera(), metric());
  drive(odometry, 15, straight);
  cv::RNG noise(5);
  const auto results = drive(
      odometry, 40, [](int) { return straight(14); },
      [&](int, cv::Mat& image) {
        cv::Mat grain(image.size(), CV_16SC1);
        noise.fill(grain, cv::RNG::NORMAL, 0, 2.0);
        cv::add(image, grain, image, cv::noArray(), CV_8U);
      });
  const int keyframes = results[1].keyframes;
  for (std::size_t i = 2; i < results.size(); ++i) {
    EXPECT_EQ(results[i].twist.norm(), 0.0) << i;
    EXPECT_FALSE(results[i].keyframe);
    EXPECT_EQ(results[i].keyframes, keyframes);
    EXPECT_LT(travelled(results, 1, i), 1e-9);
  }
  const auto onwards = drive(odometry, 10, [](int i) { return straight(15 + i); });
  EXPECT_EQ(odometry.restarts(), 0);
  EXPECT_NEAR(travelled(onwards, 0, 9), 9 * kStep, 0.04 * 9 * kStep);
}

TEST_F(OrbOdometryOnAStreet, StandingAtTheStartIsNoMotion) {
  OrbOdometry odometry(smallCamera(), metric());
  for (const OrbResult& result : drive(
           odometry, 10, [](int) { return straight(0); }, grainy)) {
    EXPECT_EQ(result.state, OrbState::kInitialising);
    EXPECT_EQ(result.twist.head<3>().norm(), 0.0);
    EXPECT_LT(result.twist.tail<3>().norm(), 0.01);  // what far features err by
  }
  EXPECT_EQ(drive(odometry, 6, straight).back().state, OrbState::kTracking);
}

/// However long it knows nothing of its speed, what it says of that can be used.
TEST_F(OrbOdometryOnAStreet, LongStandingAtTheStartIsNothingAbsurd) {
  OrbOdometry odometry(smallCamera(), metric());
  drive(
      odometry, 80, [](int) { return straight(0); }, grainy);  // 8 s
  EXPECT_EQ(drive(odometry, 20, straight, grainy).back().state, OrbState::kTracking);
}

TEST_F(OrbOdometryOnAStreet, PureRotationTurnsWithoutMoving) {
  OrbOdometry odometry(smallCamera(), metric());
  drive(odometry, 15, straight);
  const auto yaw_of = [](int i) { return 0.2 * std::sin(0.2 * (i + 1)); };
  const auto results = drive(odometry, 32, [&](int i) { return cameraAt(0.0, kStep * 14, yaw_of(i)); });
  EXPECT_EQ(odometry.restarts(), 0);
  for (std::size_t i = 1; i < results.size(); ++i) {
    EXPECT_EQ(results[i].state, OrbState::kTracking);
    EXPECT_LT(travelled(results, 0, i), 0.05);
    EXPECT_NEAR(results[i].sample.yaw_rate * kPeriod,
                yaw_of(static_cast<int>(i)) - yaw_of(static_cast<int>(i) - 1), 0.003);
  }
}

TEST_F(OrbOdometryOnAStreet, DroppedFramesCostNothing) {
  OrbOdometry odometry(smallCamera(), metric());
  std::vector<OrbResult> results;
  for (int i = 0; i < 40; ++i) {
    if (i == 20 || i == 27 || i == 28) continue;
    results.push_back(
        odometry.track(stampFromSeconds(kPeriod * i), scene().render(smallCamera(), straight(i))));
  }
  EXPECT_EQ(odometry.restarts(), 0);
  for (std::size_t i = 12; i < results.size(); ++i) {
    EXPECT_EQ(results[i].state, OrbState::kTracking);
    EXPECT_NEAR(results[i].sample.speed, kStep / kPeriod, 0.06 * kStep / kPeriod) << i;
  }
}

TEST_F(OrbOdometryOnAStreet, CoastsOverBlindFramesAndFindsBack) {
  for (const int grey : {0, 128, 255}) {
    next_frame_ = 0;
    OrbOdometry odometry(smallCamera(), metric());
    const auto results = drive(odometry, 40, straight, [&](int i, cv::Mat& image) {
      if (i >= 20 && i < 23) image.setTo(grey);
    });
    EXPECT_EQ(results[20].state, OrbState::kLost);
    EXPECT_NEAR(results[22].sample.speed, kStep / kPeriod, 0.06 * kStep / kPeriod);
    EXPECT_GT(results[22].covariance.trace(), results[19].covariance.trace());
    EXPECT_EQ(results[25].state, OrbState::kTracking);
    EXPECT_EQ(odometry.restarts(), 0);
    EXPECT_NEAR(travelled(results, 10, 39), 29 * kStep, 0.03 * 29 * kStep);
  }
}

TEST_F(OrbOdometryOnAStreet, FreshStartCarriesPoseAndScaleOn) {
  for (const bool known_height : {true, false}) {
    next_frame_ = 0;
    OrbOdometryParams params = known_height ? metric() : smallParams();
    params.ground_plane = known_height;
    OrbOdometry odometry(smallCamera(), params);
    const auto results = drive(odometry, 60, straight, [&](int i, cv::Mat& image) {
      if (i >= 25 && i < 40) image.setTo(0);
    });
    EXPECT_EQ(odometry.restarts(), 1);
    int restarted = 0;
    for (const OrbResult& result : results) restarted += result.restarted ? 1 : 0;
    EXPECT_EQ(restarted, 1);
    EXPECT_EQ(results.back().state, OrbState::kTracking);
    EXPECT_NEAR(results[58].sample.speed, results[24].sample.speed, 0.1 * results[24].sample.speed);
    for (std::size_t i = 1; i < results.size(); ++i) {
      EXPECT_LT(travelled(results, i - 1, i), 4.0 * results[24].sample.speed * kPeriod) << i;
    }
  }
}

TEST_F(OrbOdometryOnAStreet, GoesOnThroughWeakTexture) {
  OrbOdometry odometry(smallCamera(), metric());
  const auto results = drive(odometry, 35, straight, [](int i, cv::Mat& image) {
    if (i >= 15) image.convertTo(image, CV_8U, 0.2, 100);
  });
  EXPECT_EQ(odometry.restarts(), 0);
  EXPECT_EQ(results.back().state, OrbState::kTracking);
  EXPECT_NEAR(travelled(results, 10, 34), 24 * kStep, 0.04 * 24 * kStep);
}

TEST_F(OrbOdometryOnAStreet, LargeMovingObjectAheadIsNotFollowed) {
  // A textured van that keeps its distance: a third of the road ahead never moves in the image.
  const cv::Mat van = scene().render(smallCamera(), cameraAt(2.0, 300.0))(cv::Rect(0, 60, 150, 75)).clone();
  OrbOdometry odometry(smallCamera(), metric());
  const auto results = drive(odometry, 45, straight, [&](int i, cv::Mat& image) {
    if (i >= 12) van.copyTo(image(cv::Rect(165, 45, 150, 75)));
  });
  EXPECT_EQ(odometry.restarts(), 0);
  EXPECT_NEAR(travelled(results, 14, 44), 30 * kStep, 0.04 * 30 * kStep);
}

TEST_F(OrbOdometryOnAStreet, ThereAndBackKeepsScaleAndSign) {
  for (const bool known_height : {true, false}) {
    next_frame_ = 0;
    OrbOdometry odometry(smallCamera(), known_height ? metric() : smallParams());
    const auto forth = drive(odometry, 35, straight);
    const auto back = drive(odometry, 25, [](int i) { return straight(33 - i); });
    EXPECT_EQ(odometry.restarts(), 0);
    EXPECT_LT(back.back().sample.speed, 0.0);
    const double out = travelled(forth, 20, 34) / 14.0;
    const double home = travelled(back, 4, 24) / 20.0;
    EXPECT_NEAR(home / out, 1.0, 0.04);
    const double off = (place(back.back()) - place(forth[9])).norm();
    EXPECT_LT(off, 0.04 * 50.0 * out);
  }
}

TEST_F(OrbOdometryOnAStreet, NominalSpeedBringsTheUnitNearMetres) {
  OrbOdometryParams params = smallParams();
  params.nominal_speed = kStep / kPeriod;
  OrbOdometry odometry(smallCamera(), params);
  const auto results = drive(odometry, 25, straight);
  EXPECT_NEAR(results.back().sample.speed, kStep / kPeriod, 0.08 * kStep / kPeriod);
}

TEST_F(OrbOdometryOnAStreet, TwoRunsGiveTheSameBits) {
  std::vector<OrbResult> runs[2];
  for (auto& run : runs) {
    next_frame_ = 0;
    OrbOdometry odometry(smallCamera(), metric());
    run = drive(odometry, 20, straight);
  }
  for (std::size_t i = 0; i < runs[0].size(); ++i) {
    EXPECT_EQ(0, std::memcmp(runs[0][i].twist.data(), runs[1][i].twist.data(), sizeof(Vector6))) << i;
    EXPECT_TRUE(runs[0][i].sample.pose->matrix() == runs[1][i].sample.pose->matrix());
  }
}

TEST_F(OrbOdometryOnAStreet, ThreadsDoNotChangeABit) {
  std::vector<OrbResult> runs[3];
  for (int run = 0; run < 3; ++run) {
    OrbOdometryParams params = metric();
    params.threads = 1 + run;
    OrbOdometry odometry(smallCamera(), params);
    next_frame_ = 0;
    runs[run] = drive(
        odometry, 30, [](int i) { return cameraAt(0.0, kStep * i, 0.01 * i); },
        [](int i, cv::Mat& image) {
          if (i == 20) image.setTo(128);  // finding back goes through all parts
        });
  }
  for (int run = 1; run < 3; ++run) {
    for (std::size_t i = 0; i < runs[0].size(); ++i) {
      const OrbResult& alone = runs[0][i];
      const OrbResult& shared = runs[run][i];
      EXPECT_EQ(0, std::memcmp(alone.sample.pose->data(), shared.sample.pose->data(), 16 * sizeof(double)))
          << i;
      EXPECT_EQ(0, std::memcmp(alone.twist.data(), shared.twist.data(), sizeof(Vector6))) << i;
      EXPECT_EQ(0, std::memcmp(alone.covariance.data(), shared.covariance.data(), sizeof(Matrix6))) << i;
      EXPECT_EQ(alone.tracked_points, shared.tracked_points) << i;
      EXPECT_EQ(alone.landmarks, shared.landmarks) << i;
    }
  }
}

TEST_F(OrbOdometryOnAStreet, ThreadsMustExist) {
  OrbOdometryParams params = metric();
  params.threads = 0;
  EXPECT_THROW(OrbOdometry(smallCamera(), params), std::invalid_argument);
}

TEST_F(OrbOdometryOnAStreet, MapStaysBounded) {
  OrbOdometryParams params = smallParams();
  params.map_keyframes = 12;
  OrbOdometry odometry(smallCamera(), params);
  std::size_t most = 0;
  for (int i = 0; i < 60; ++i) {
    drive(odometry, 1, [&](int) { return straight(i); });
    if (!odometry.map()) continue;
    EXPECT_LE(odometry.map()->keyframes().size(), 12U);
    most = std::max(most, odometry.map()->landmarks().size());
    for (const Landmark& landmark : odometry.map()->landmarks()) {
      EXPECT_LE(landmark.observations.size(), 12U);
      EXPECT_NE(odometry.map()->keyframe(landmark.reference), nullptr);
    }
  }
  EXPECT_LT(most, 12U * 150U);
}

TEST_F(OrbOdometryOnAStreet, RepeatedAndOlderStampsAreIgnoredAndCounted) {
  OrbOdometry odometry(smallCamera(), metric());
  const auto results = drive(odometry, 12, straight);
  const cv::Mat image = scene().render(smallCamera(), straight(12));
  for (const int frame : {11, 3}) {
    const OrbResult again = odometry.track(stampFromSeconds(kPeriod * frame), image);
    EXPECT_TRUE(again.ignored);
    EXPECT_EQ(again.twist.norm(), 0.0);
    EXPECT_EQ(again.sample.stamp, results.back().sample.stamp);
    EXPECT_TRUE(again.sample.pose->matrix() == results.back().sample.pose->matrix());
  }
  EXPECT_EQ(odometry.ignoredFrames(), 2);
  EXPECT_EQ(drive(odometry, 1, [](int) { return straight(12); }).back().state, OrbState::kTracking);
}

TEST_F(OrbOdometryOnAStreet, AnotherImageSizeIsAnErrorThatLeavesTheStateAlone) {
  OrbOdometry odometry(smallCamera(), metric());
  drive(odometry, 12, straight);
  EXPECT_THROW(odometry.track(stampFromSeconds(9.0), cv::Mat(100, 100, CV_8UC1)), std::invalid_argument);
  EXPECT_THROW(odometry.track(stampFromSeconds(9.0), cv::Mat(160, 480, CV_32FC1)), std::invalid_argument);
  EXPECT_EQ(drive(odometry, 1, [](int) { return straight(12); }).back().state, OrbState::kTracking);
}

TEST_F(OrbOdometryOnAStreet, ColourImagesAreTakenToo) {
  OrbOdometry odometry(smallCamera(), metric());
  const auto results = drive(odometry, 8, straight,
                             [](int, cv::Mat& image) { cv::cvtColor(image, image, cv::COLOR_GRAY2BGR); });
  EXPECT_EQ(results.back().state, OrbState::kTracking);
}

TEST(OrbOdometryParams, BadValuesAreNamed) {
  OrbOdometryParams params;
  params.fast_min_threshold = 30;
  EXPECT_THROW(params.validate(), std::invalid_argument);
  params = {};
  params.map_keyframes = params.window_keyframes;
  EXPECT_THROW(OrbOdometry(smallCamera(), params), std::invalid_argument);
  params = {};
  params.init_points = params.features + 1;
  EXPECT_THROW(params.validate(), std::invalid_argument) << "no map could begin";
  params = {};
  params.camera_height = std::nan("");
  try {
    params.validate();
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("camera_height"), std::string::npos);
  }
}

}  // namespace
}  // namespace ratslam
