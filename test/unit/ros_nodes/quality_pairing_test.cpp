#include "ratslam_ros/support/quality_pairing.h"

#include <gtest/gtest.h>

namespace ratslam {
namespace {

OdometrySample sample(int second) {
  OdometrySample s;
  s.stamp = Stamp{1000000000} * second;
  return s;
}

/// Tells its lap by the epoch.
ratslam_ros::OdometryQuality quality(int second, std::uint32_t lap) {
  ratslam_ros::OdometryQuality q;
  q.header.stamp = ros::Time(second, 0);
  q.epoch = lap;
  return q;
}

TEST(QualityPairing, AQualityThatRunsALapAheadStaysWithItsSample) {
  QualityPairing pairing;
  for (std::uint32_t lap = 1; lap <= 2; ++lap) {
    for (int second = 10; second < 20; ++second) pairing.hearQuality(quality(second, lap));
  }
  for (std::uint32_t lap = 1; lap <= 2; ++lap) {
    for (int second = 10; second < 20; ++second) {
      pairing.hearSample(sample(second));
      const auto next = pairing.next(true);
      ASSERT_TRUE(next) << second;
      EXPECT_EQ(next->stamp, sample(second).stamp);
      EXPECT_EQ(next->epoch, lap) << second;
    }
  }
}

TEST(QualityPairing, SamplesThatRunALapAheadWaitForTheirQualities) {
  QualityPairing pairing;
  for (int lap = 0; lap < 2; ++lap) {
    for (int second = 10; second < 20; ++second) pairing.hearSample(sample(second));
  }
  EXPECT_FALSE(pairing.next(true));
  for (std::uint32_t lap = 1; lap <= 2; ++lap) {
    for (int second = 10; second < 20; ++second) {
      pairing.hearQuality(quality(second, lap));
      const auto next = pairing.next(true);
      ASSERT_TRUE(next) << second;
      EXPECT_EQ(next->epoch, lap) << second;
      EXPECT_FALSE(pairing.next(true));
    }
  }
}

TEST(QualityPairing, ALostQualityDelaysNothingAndALostSampleLeavesNothingBehind) {
  QualityPairing pairing;
  pairing.hearSample(sample(10));
  pairing.hearSample(sample(11));
  pairing.hearQuality(quality(9, 7));
  EXPECT_FALSE(pairing.next(true)) << "the quality of a sample before may still be followed by this one's";
  pairing.hearQuality(quality(11, 7));
  pairing.hearSample(sample(12));
  std::vector<std::uint32_t> epochs;
  while (const auto next = pairing.next(false)) epochs.push_back(next->epoch);
  EXPECT_EQ(epochs, (std::vector<std::uint32_t>{0, 7, 0}));
  EXPECT_FALSE(pairing.waits());
  pairing.hearQuality(quality(14, 7));
  pairing.hearSample(sample(13));
  EXPECT_TRUE(pairing.next(true)) << "its quality can no longer come";
}

}  // namespace
}  // namespace ratslam
