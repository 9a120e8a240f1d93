/// What the odometry says of stretches that it did not measure: never that the camera stood still.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <functional>

#include "ratslam/odometry/orb/orb_odometry.h"
#include "ratslam/system/image_stage.h"
#include "street_scene.h"

namespace ratslam {
namespace {

using test::cameraAt;
using test::kPeriod;
using test::kStep;
using test::smallCamera;
using test::smallParams;
using test::StreetScene;

using Spoil = std::function<void(int, cv::Mat&)>;
using PoseOf = std::function<RigidTransform(int)>;

RigidTransform straight(int i) { return cameraAt(0.0, kStep * i); }
void leaveAsIs(int, cv::Mat&) {}

/// The motion of base_link from one frame to another.
Eigen::Isometry3d trueMotion(const PoseOf& pose_of, int from, int to) {
  RigidTransform base_from_camera;
  base_from_camera.rotation = Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5);
  return (base_from_camera * pose_of(from).inverse() * pose_of(to) * base_from_camera.inverse()).isometry();
}

class Bridging : public testing::Test {
 protected:
  /// Feeds the frames that `wanted` lets through.
  std::vector<OrbResult> drive(
      int frames, const PoseOf& pose_of, const Spoil& spoil = leaveAsIs,
      const std::function<bool(int)>& wanted = [](int) { return true; }) {
    static const StreetScene scene;
    OrbOdometryParams params = smallParams();
    params.camera_height = StreetScene::kCameraHeight;
    OrbOdometry odometry(smallCamera(), params);
    ImageStage stage(ImageStageParams{}, [](ImageEvent, const std::string&) {});
    std::vector<OrbResult> results;
    qualities_.clear();
    for (int i = 0; i < frames; ++i) {
      if (!wanted(i)) continue;
      cv::Mat image = scene.render(smallCamera(), pose_of(i));
      spoil(i, image);
      const auto frame = stage.add({stampFromSeconds(kPeriod * i), "image", image, {}});
      EXPECT_TRUE(frame);
      qualities_.push_back(frame->quality);
      results.push_back(odometry.track(frame->stamp, frame->image, frame->quality));
    }
    restarts_ = odometry.restarts();
    return results;
  }
  static int frameAt(Stamp stamp) { return static_cast<int>(std::lround(toSeconds(stamp) / kPeriod)); }
  static std::vector<OrbResult> corrections(const std::vector<OrbResult>& results) {
    std::vector<OrbResult> found;
    for (const OrbResult& result : results) {
      if (result.sample.correction) found.push_back(result);
    }
    return found;
  }
  /// Squared error of a correction, normalised by its covariance.
  static double normalisedError(const OdometryCorrection& correction, const PoseOf& pose_of) {
    const Eigen::Isometry3d truth = trueMotion(pose_of, frameAt(correction.from), frameAt(correction.to));
    Vector6 error;
    error.head<3>() = correction.motion.translation() - truth.translation();
    error.tail<3>() =
        logRotation(Eigen::Quaterniond(correction.motion.linear() * truth.linear().transpose()));
    return error.dot(Matrix6(correction.covariance).ldlt().solve(error));
  }
  static void expectEverythingElseIsKnown(const std::vector<OrbResult>& results) {
    for (const OrbResult& result : results) {
      const bool tracks = result.state == OrbState::kTracking;
      EXPECT_EQ(result.sample.bridged, !tracks && &result != &results.front());
      ASSERT_TRUE(result.sample.unit);
      if (&result == &results.front()) continue;
      ASSERT_TRUE(result.sample.covariance);
      const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(Matrix6(*result.sample.covariance));
      EXPECT_GT(eigen.eigenvalues().minCoeff(), 0.0);
      EXPECT_TRUE(result.sample.covariance->allFinite());
    }
  }

  std::vector<ImageQuality> qualities_;
  std::int64_t restarts_ = 0;
};

TEST_F(Bridging, FirstMapBringsTheMotionSinceTheFirstFrame) {
  const auto results = drive(12, straight);
  expectEverythingElseIsKnown(results);
  const auto found = corrections(results);
  ASSERT_EQ(found.size(), 1U);
  const OdometryCorrection& correction = *found[0].sample.correction;
  EXPECT_EQ(correction.from, results.front().sample.stamp);
  EXPECT_EQ(correction.to, found[0].sample.stamp);
  EXPECT_TRUE(correction.motion.isApprox(*found[0].sample.pose, 1e-12));
  EXPECT_LT(normalisedError(correction, straight), 17.0);  // 99 % of six degrees of freedom
  EXPECT_NEAR(found[0].sample.speed, kStep / kPeriod, 0.2 * kStep / kPeriod);
}

TEST_F(Bridging, FrozenCameraIsNotStandingStill) {
  cv::Mat frozen;
  const auto results = drive(40, straight, [&](int i, cv::Mat& image) {
    if (i == 20) frozen = image.clone();
    if (i > 20 && i < 30) image = frozen.clone();
  });
  expectEverythingElseIsKnown(results);
  for (std::size_t i = 21; i < 30; ++i) {
    EXPECT_EQ(qualities_[i], ImageQuality::kFrozen);
    EXPECT_TRUE(results[i].sample.bridged);
    EXPECT_NEAR(results[i].sample.speed, kStep / kPeriod, 0.1 * kStep / kPeriod);
  }
  const auto found = corrections(results);
  ASSERT_EQ(found.size(), 2U);
  const OdometryCorrection& correction = *found[1].sample.correction;
  EXPECT_EQ(frameAt(correction.from), 20);
  EXPECT_LE(frameAt(correction.to), 39);
  EXPECT_EQ(correction.to, found[1].sample.stamp);
  EXPECT_LT(normalisedError(correction, straight), 17.0);
  EXPECT_NEAR(correction.motion.translation().norm(), kStep * (frameAt(correction.to) - 20), 0.5);
}

/// A camera without noise repeats its image as long as the car stands. The map's first frame is then older than all
/// that were seen on the way.
TEST_F(Bridging, WhoPullsAwayFromRestHasEachPlaceFromThereOn) {
  const int rest = 12;
  const auto pulls_away = [](int i) {
    const int driven = std::max(i - rest, 0);
    return cameraAt(0.0, 0.05 * driven + 0.005 * driven * driven);
  };
  const auto found = corrections(drive(50, pulls_away));
  ASSERT_EQ(qualities_[rest], ImageQuality::kFrozen);
  ASSERT_EQ(qualities_[rest + 1], ImageQuality::kUsable);
  ASSERT_EQ(found.size(), 1U);
  const OdometryCorrection& correction = *found[0].sample.correction;
  const double scale = correction.motion.translation().norm() /
                       trueMotion(pulls_away, 0, frameAt(correction.to)).translation().norm();
  EXPECT_NEAR(scale, 1.0, 0.15);
  for (const auto& place : correction.way) {
    const Eigen::Vector3d truth = trueMotion(pulls_away, 0, frameAt(place.stamp)).translation();
    EXPECT_LT((place.motion.translation() - scale * truth).norm(), 0.07) << "frame " << frameAt(place.stamp);
  }
}

TEST_F(Bridging, PoseGoesOnByTheCorrectionAndTheWayLeadsThere) {
  const auto results = drive(50, straight, [](int i, cv::Mat& image) {
    if (i >= 20 && i < 40) image.setTo(i < 30 ? 250 : 2);
  });
  const auto found = corrections(results);
  ASSERT_EQ(found.size(), 2U);
  const OdometryCorrection& correction = *found[1].sample.correction;
  const OrbResult& before = results[static_cast<std::size_t>(frameAt(correction.from))];
  EXPECT_TRUE((*before.sample.pose * correction.motion).isApprox(*found[1].sample.pose, 1e-9));
  ASSERT_EQ(correction.way.size(),
            static_cast<std::size_t>(frameAt(correction.to) - frameAt(correction.from) - 1));
  int frame = frameAt(correction.from);
  for (const StampedMotion& sample : correction.way) {
    EXPECT_EQ(frameAt(sample.stamp), ++frame);
    EXPECT_NEAR(sample.motion.translation().x(), kStep * (frame - 19), 1.0);
  }
  EXPECT_EQ(qualities_[20], ImageQuality::kBlank);
}

TEST_F(Bridging, LongGapIsBridgedBySpeedBeforeAndAfter) {
  // The car gets faster where nobody looks: 0.4 m a frame before, 0.7 m after.
  const PoseOf pose_of = [](int i) {
    const double into = std::clamp(i - 25.0, 0.0, 40.0);
    const double beyond = std::max(0.0, i - 65.0);
    return cameraAt(0.0, kStep * i + 0.5 * 0.3 / 40.0 * into * into + 0.3 * beyond);
  };
  const auto results = drive(85, pose_of, leaveAsIs, [](int i) { return i <= 25 || i >= 65; });
  const auto found = corrections(results);
  ASSERT_EQ(found.size(), 2U);
  const OdometryCorrection& correction = *found[1].sample.correction;
  EXPECT_EQ(frameAt(correction.from), 25);
  EXPECT_LT(normalisedError(correction, pose_of), 17.0);
  const double way = trueMotion(pose_of, 25, frameAt(correction.to)).translation().norm();
  EXPECT_NEAR(correction.motion.translation().norm(), way, 0.1 * way);
  EXPECT_NEAR(results.back().sample.speed, 7.0, 0.7);
}

TEST_F(Bridging, EpochIsThatOfTheSourceNotOfItsMaps) {
  const auto results = drive(60, straight, [](int i, cv::Mat& image) {
    if (i >= 20 && i < 45) image.setTo(0);
  });
  for (const OrbResult& result : results) EXPECT_EQ(result.sample.epoch, results.front().sample.epoch);
  static const StreetScene scene;
  OrbOdometry later(smallCamera(), smallParams());
  const OrbResult first = later.track(stampFromSeconds(3.0), scene.render(smallCamera(), straight(0)));
  EXPECT_NE(first.sample.epoch, results.front().sample.epoch);
}

TEST_F(Bridging, RoadAndHeightAnchorTheUnit) {
  const auto results = drive(40, straight);
  ASSERT_TRUE(results.back().sample.unit->anchor_sigma);
  EXPECT_GT(*results.back().sample.unit->anchor_sigma, 0.0);
  EXPECT_LT(*results.back().sample.unit->anchor_sigma, 0.05);
  EXPECT_GT(results.back().sample.unit->constant_sigma, 0.0) << "the height is measured by hand";
  EXPECT_FALSE(results[2].sample.unit->anchor_sigma);
}

}  // namespace
}  // namespace ratslam
