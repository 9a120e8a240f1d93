/// An odometry that is saved at any frame, loaded and continued gives the bits of one that was never stopped.
#include <gtest/gtest.h>

#include "ratslam/common/state.h"
#include "ratslam/odometry/orb/orb_source.h"
#include "street_scene.h"

namespace ratslam {
namespace {

using test::cameraAt;
using test::smallCamera;
using test::smallParams;
using test::StreetScene;

constexpr int kFrames = 52;

/// A drive with a start, a blackout that is tracked through on the old map, and one that ends in a fresh map.
const std::vector<ImageFrame>& drive() {
  static const std::vector<ImageFrame> frames = [] {
    const StreetScene scene;
    std::vector<ImageFrame> result;
    for (int i = 0; i < kFrames; ++i) {
      ImageFrame frame;
      frame.stamp = stampFromSeconds(0.1 * i);
      frame.image = scene.render(smallCamera(), cameraAt(0.0, 0.4 * i));
      const bool dark = (i >= 12 && i < 15) || (i >= 22 && i < 40);
      if (dark) frame.quality = ImageQuality::kBlank;
      result.push_back(frame);
    }
    return result;
  }();
  return frames;
}

OrbSource source() {
  OrbOdometryParams params = smallParams();
  params.camera_height = StreetScene::kCameraHeight;
  return OrbSource(smallCamera(), params);
}

State stateOf(const OrbSource& odometry) {
  State state;
  odometry.save(state);
  return state;
}

/// Of frames in which the robot is not where it was, the odometry's frame knows nothing: its pose must not jump (REP-105).
TEST(OrbSource, ThePoseGoesOnWhereTheImagesBeginAnew) {
  OrbSource odometry = source();
  Eigen::Isometry3d last = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 10; ++i) last = *odometry.track(drive()[static_cast<std::size_t>(i)]).pose;
  ASSERT_GT(last.translation().norm(), 1.0);
  ImageFrame anew = drive()[1];
  anew.begins_anew = true;
  const Eigen::Isometry3d first = *odometry.track(anew).pose;
  EXPECT_LT((first.translation() - last.translation()).norm(), 1e-9);
  EXPECT_TRUE(first.linear().isApprox(last.linear(), 1e-9));
}

TEST(OrbState, GoesOnAsIfItHadNeverStopped) {
  OrbSource whole = source();
  std::vector<std::vector<std::uint8_t>> saved;
  std::vector<State> samples;
  std::vector<State> taken;
  for (const ImageFrame& frame : drive()) {
    saved.push_back(stateOf(whole).toBytes());
    taken.push_back(stateOf(whole));
    const OdometrySample sample = whole.track(frame);
    samples.emplace_back();
    samples.back().set("sample", sample);
  }
  for (std::size_t i = 0; i < taken.size(); ++i)
    EXPECT_TRUE(taken[i].toBytes() == saved[i]) << "looked at later, taken at " << i;
  ASSERT_EQ(whole.odometry().restarts(), 1) << "the drive is meant to have a fresh map";
  // Before the first frame, before the first map, on a map, blind, on the way back, and while the fresh map is young.
  for (const std::size_t stop : {0U, 1U, 8U, 13U, 15U, 30U, 41U, 43U, 50U}) {
    OrbSource continued = source();
    continued.load(State::fromBytes(saved[stop]));
    EXPECT_TRUE(stateOf(continued).toBytes() == saved[stop]) << "saved again at " << stop;
    for (std::size_t i = stop; i < drive().size(); ++i) {
      State sample;
      sample.set("sample", continued.track(drive()[i]));
      ASSERT_TRUE(sample == samples[i]) << "stopped at " << stop << ", frame " << i;
    }
    EXPECT_TRUE(stateOf(continued) == stateOf(whole)) << "stopped at " << stop;
  }
}

TEST(OrbState, StateOfAnotherCameraIsRefused) {
  OrbSource whole = source();
  for (std::size_t i = 0; i < 10; ++i) whole.track(drive()[i]);
  CameraModel other = smallCamera();
  other.width = 320;
  OrbSource wrong(other, smallParams());
  EXPECT_THROW(wrong.load(stateOf(whole)), std::runtime_error);
}

}  // namespace
}  // namespace ratslam
