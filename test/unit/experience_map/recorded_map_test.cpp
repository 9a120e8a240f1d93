/// Accuracy of the default map on KITTI 00 (1700 frames, one loop), similarity-aligned: it must not spoil
/// good odometry and must mend bad one.
#include <gtest/gtest.h>

#include <random>

#include "recorded_drive.h"

namespace ratslam {
namespace {

class RecordedMap : public testing::Test {
 protected:
  void SetUp() override {
    drive_ = readReferenceDrive();
    truth_ = readKittiPositions(dataFolder() + "/kitti_00/poses.txt");
    if (drive_.empty() || truth_.cols() == 0) GTEST_SKIP() << "no reference run in " << dataFolder();
    ASSERT_EQ(truth_.cols(), static_cast<Eigen::Index>(drive_.size()));
  }

  double finalError(const std::vector<DriveStep>& drive, const ExperienceMapParams& params) const {
    ExperienceMap map(params);
    run(map, drive);
    map.settle();
    return meanApe(positionsOf(map.finalTrajectory()), truth_);
  }

  double deadReckoningError(const std::vector<DriveStep>& drive) const {
    ExperienceMap map{ExperienceMapParams{}};
    map.start(drive.front().end);
    for (std::size_t k = 1; k < drive.size(); ++k) map.integrate(drive[k].end, drive[k].motion);
    return meanApe(positionsOf(map.finalTrajectory()), truth_);
  }

  std::vector<DriveStep> drive_;
  Eigen::Matrix3Xd truth_;
};

TEST_F(RecordedMap, DoesNotSpoilTheTrueOdometry) {
  ExperienceMapParams params;
  EXPECT_LE(deadReckoningError(drive_), 0.77);
  EXPECT_LE(finalError(drive_, params), 0.80);
  params.exp_scale = true;
  EXPECT_LE(finalError(drive_, params), 0.90);
}

/// A bias of the scale of 2% standard deviation a run, and 0.002 rad of yaw noise a frame.
TEST_F(RecordedMap, MendsNoisyOdometry) {
  double map_sum = 0.0;
  double dead_reckoning_sum = 0.0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    std::vector<DriveStep> noisy = drive_;
    const double scale = 1.0 + 0.02 * normal(random);
    for (DriveStep& step : noisy) {
      step.motion.forward *= scale;
      step.motion.rotation += 0.002 * normal(random);
    }
    const double map = finalError(noisy, ExperienceMapParams{});
    const double dead_reckoning = deadReckoningError(noisy);
    RecordProperty("seed" + std::to_string(seed),
                   std::to_string(dead_reckoning) + " -> " + std::to_string(map));
    EXPECT_LT(map, dead_reckoning) << "seed " << seed;
    map_sum += map;
    dead_reckoning_sum += dead_reckoning;
  }
  EXPECT_LT(map_sum, 0.6 * dead_reckoning_sum);
}

/// As ORB-SLAM2's unit of length does here: it shrinks by a third over the drive.
TEST_F(RecordedMap, MendsAUnitOfLengthThatShrinksByAThird) {
  std::vector<DriveStep> drifting = drive_;
  double way = 0.0;
  for (DriveStep& step : drifting) {
    way += step.motion.forward;
    step.motion.forward *= std::exp(-std::log(1.5) * way / 1200.0);
  }
  ExperienceMapParams params;
  params.exp_scale = true;
  EXPECT_GT(deadReckoningError(drifting), 14.0);
  EXPECT_LE(finalError(drifting, params), 1.3);
}

}  // namespace
}  // namespace ratslam
