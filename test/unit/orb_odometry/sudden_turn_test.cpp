/// A turn that comes all at once, in front of walls full of features that look alike.
#include <gtest/gtest.h>

#include "ratslam/odometry/orb/orb_odometry.h"
#include "town/drive.h"
#include "town/town.h"
#include "town/town_renderer.h"

namespace ratslam {
namespace {

constexpr int kFrames = 40;
constexpr int kTurnAt = 30;

class OrbOdometryAtASuddenTurn : public testing::TestWithParam<double> {};

TEST_P(OrbOdometryAtASuddenTurn, DoesNotMistakeOtherFeaturesForThoseItExpects) {
  static const Drive path = planTownDrive(kFrames);
  static const Town town(path.roads, 1);
  const TownCamera lens = TownCamera::kittiLike(620, 188);
  const TownRenderer renderer(town, lens);
  const CameraModel camera{lens.width, lens.height, lens.fx, lens.fy, lens.cx, lens.cy, LensModel::kNone, {}};
  OrbOdometryParams params;
  params.features = 1200;
  params.camera_height = 1.65;
  OrbOdometry odometry(camera, params);
  for (int i = 0; i < kFrames; ++i) {
    const auto& pose = path.poses[static_cast<std::size_t>(i)];
    Eigen::Isometry3d T_world_camera = pose.T_world_camera;
    if (i >= kTurnAt) T_world_camera.rotate(Eigen::AngleAxisd(-GetParam(), Eigen::Vector3d::UnitY()));
    const OrbResult result = odometry.track(pose.stamp, renderer.render(T_world_camera));
    if (i < kTurnAt) continue;
    const auto& before = path.poses[static_cast<std::size_t>(i) - 1];
    const double dt = secondsBetween(before.stamp, pose.stamp);
    const double speed =
        (pose.T_world_camera.translation() - before.T_world_camera.translation()).norm() / dt;
    EXPECT_EQ(result.state, OrbState::kTracking) << i;
    EXPECT_NEAR(result.twist.head<3>().norm(), speed, 0.25 * speed) << i;
    if (i > kTurnAt) continue;
    const Eigen::Isometry3d step = before.T_world_camera.inverse() * T_world_camera;
    EXPECT_NEAR(result.twist(5) * dt,
                -Eigen::AngleAxisd(step.linear()).angle() * Eigen::AngleAxisd(step.linear()).axis().y(),
                0.005);
  }
  EXPECT_EQ(odometry.restarts(), 0);
}

INSTANTIATE_TEST_SUITE_P(Angles, OrbOdometryAtASuddenTurn, testing::Values(-0.1, 0.05, 0.08));

}  // namespace
}  // namespace ratslam
