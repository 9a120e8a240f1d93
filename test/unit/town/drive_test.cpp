#include "town/drive.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "ratslam/common/angles.h"
#include "town/footprint.h"
#include "town/town_parts.h"
#include "town_test_support.h"

namespace ratslam {
namespace {

double headingBetween(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Eigen::Vector3d u = a.linear().col(2);
  const Eigen::Vector3d v = b.linear().col(2);
  return std::abs(wrapAngle(std::atan2(u.x(), u.z()) - std::atan2(v.x(), v.z())));
}

/// Times the drive comes to a place it knows, with headings that agree (or oppose) within 0.3 rad: runs of
/// frames that lie within `reach` of a frame at least 10 s earlier, each longer than 15 frames. A run also
/// ends where the earlier frames it retraces jump.
int countRevisits(const Drive& drive, bool opposed, double reach) {
  int runs = 0;
  int length = 0;
  int last_match = -1;
  const int count = static_cast<int>(drive.poses.size());
  for (int i = 0; i < count; ++i) {
    int match = -1;
    double nearest = reach;
    const auto& now = drive.poses[static_cast<std::size_t>(i)].T_world_camera;
    for (int k = 0; k < i - 100; ++k) {
      const auto& then = drive.poses[static_cast<std::size_t>(k)].T_world_camera;
      const double turn = headingBetween(now, then);
      if (opposed ? turn < kPi - 0.3 : turn > 0.3) continue;
      const double distance = (now.translation() - then.translation()).norm();
      if (distance < nearest) {
        nearest = distance;
        match = k;
      }
    }
    const bool goes_on = match >= 0 && last_match >= 0 && std::abs(match - last_match) < 20;
    length = match < 0 ? 0 : (goes_on ? length + 1 : 1);
    if (length == 15) ++runs;
    last_match = match;
  }
  return runs;
}

TEST(TownDrive, RevisitsStreetsInBothDirectionsWithinTheDemo) {
  const Drive drive = planTownDrive(600);
  EXPECT_GE(countRevisits(drive, false, 1.0), 3);
  EXPECT_GE(countRevisits(drive, true, 4.0), 1);
}

TEST(TownDrive, MovesLikeACar) {
  const Drive drive = planTownDrive(1500);  // more than one round
  EXPECT_TRUE(drive.poses[0].T_world_camera.isApprox(Eigen::Isometry3d::Identity(), 1e-9));
  double slowest = 1e9;
  double fastest = 0.0;
  for (std::size_t i = 1; i < drive.poses.size(); ++i) {
    const Eigen::Isometry3d& a = drive.poses[i - 1].T_world_camera;
    const Eigen::Isometry3d& b = drive.poses[i].T_world_camera;
    EXPECT_EQ(drive.poses[i].stamp - drive.poses[i - 1].stamp, 100000000);
    const Eigen::Vector3d step = b.translation() - a.translation();
    slowest = std::min(slowest, 10.0 * step.norm());
    fastest = std::max(fastest, 10.0 * step.norm());
    EXPECT_LT(10.0 * headingBetween(a, b), 1.2) << "yaw rate in frame " << i;
    // The wheels roll: motion is along the mean heading.
    const Eigen::Vector3d ahead = (a.linear().col(2) + b.linear().col(2)).normalized();
    EXPECT_GT(ahead.dot(step.normalized()), 0.999) << "sideways motion in frame " << i;
  }
  EXPECT_GE(slowest, 4.5);
  EXPECT_LE(fastest, 12.0);
  EXPECT_LT(slowest, 7.0) << "it should slow down in turns";
}

TEST(TownDrive, TownDoesNotDependOnTheNumberOfFrames) {
  const Drive one = planTownDrive(1);
  const Drive many = planTownDrive(900);
  ASSERT_EQ(one.roads.size(), many.roads.size());
  for (std::size_t i = 0; i < one.roads.size(); ++i) {
    ASSERT_EQ(one.roads[i].size(), many.roads[i].size());
    for (std::size_t k = 0; k < one.roads[i].size(); ++k) EXPECT_EQ(one.roads[i][k].x, many.roads[i][k].x);
  }
  EXPECT_THROW(planTownDrive(0), std::invalid_argument);
}

std::string poseLine(double x, double y, double z) {
  return "1 0 0 " + std::to_string(x) + " 0 1 0 " + std::to_string(y) + " 0 0 1 " + std::to_string(z) + "\n";
}

TEST(RecordedDrive, RidesAtCameraHeightWhereHeightsDisagree) {
  // Up and down a straight road; on the way back the recording says 1 m more.
  TemporaryFolder folder;
  std::ofstream file(folder / "poses.txt");
  for (int i = 0; i < 60; ++i) file << poseLine(0.0, 0.0, i);
  for (int i = 0; i < 20; ++i)
    file << poseLine(0.5 * (20 - std::abs(i - 10)), -i / 20.0, 60.0 + 0.5 * (10 - std::abs(i - 10)));
  for (int i = 0; i < 60; ++i) file << "-1 0 0 1 0 1 0 -1 0 0 -1 " << 59 - i << "\n";
  file.close();
  Drive drive = loadDrive(folder / "poses.txt", "", 0);
  const Drive recorded = drive;
  const RoadField roads(drive.roads);
  settleOnRoad(drive, roads);
  for (std::size_t i = 0; i < drive.poses.size(); ++i) {
    const Eigen::Vector3d& place = drive.poses[i].T_world_camera.translation();
    // In the turn the recorded path is bent sharply, and that stays.
    const bool straight = i < 50 || i > 90;
    EXPECT_NEAR(-place.y() - roads.height(place.x(), place.z()), kCameraHeight, straight ? 0.02 : 0.25) << i;
    EXPECT_EQ(place.x(), recorded.poses[i].T_world_camera.translation().x());
    EXPECT_EQ(place.z(), recorded.poses[i].T_world_camera.translation().z());
  }
  // Half-way between the two opinions.
  EXPECT_NEAR(-drive.poses[30].T_world_camera.translation().y(), 0.5, 0.1);
}

TEST(RecordedDrive, SaysWhatIsWrongWithItsFiles) {
  TemporaryFolder folder;
  const auto write = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    return folder / name;
  };
  const std::string good = write("good.txt", poseLine(0, 0, 0) + poseLine(0, 0, 1) + poseLine(0, 0, 2));
  const auto fails = [](const std::string& poses, const std::string& times, const std::string& expected) {
    const std::string said = complaint([&] { loadDrive(poses, times, 0); });
    EXPECT_NE(said.find(expected), std::string::npos) << said;
  };
  EXPECT_THROW(loadDrive(folder / "none.txt", "", 0), std::runtime_error);
  EXPECT_THROW(loadDrive(folder.path(), "", 0), std::runtime_error);
  fails(write("empty.txt", ""), "", "empty.txt: it holds no lines");
  fails(write("short.txt", poseLine(0, 0, 0) + "1 2 3\n"), "", "line 2: it must hold 12 numbers");
  fails(write("word.txt", "1 0 0 0 0 1 0 0 0 0 x 0\n"), "", "line 1: it must hold 12 numbers");
  fails(write("scaled.txt", "2 0 0 0 0 2 0 0 0 0 2 0\n"), "", "line 1: it is not a rigid motion");
  fails(good, write("few.txt", "0\n0.1\n"), "it has 2 times for 3 poses");
  fails(write("gap.txt", poseLine(0, 0, 0) + "\n\n1 2 3\n"), "", "line 4: it must hold 12 numbers");
  fails(good, write("back.txt", "0\n0.2\n0.1\n"), "line 3: times must increase");
  fails(good, write("same.txt", "0\n0.2\n0.2000000001\n"), "line 3: times must increase");  // in nanoseconds
  fails(good, write("far.txt", "0\n0.2\n1e300\n"), "line 3: a time must lie within [0, 4e9] s");
  fails(good, write("before.txt", "-1\n0.2\n1\n"), "line 1: a time must lie within [0, 4e9] s");
  fails(good, write("long.txt", "5\n0.2e2\n2e6\n"), "line 3: a drive must end within 1e6 s");
  fails(write("still.txt", poseLine(0, 0, 0)), good, "must hold 1 numbers");
  EXPECT_EQ(loadDrive(good, write("times.txt", "5\n5.25\n6\n"), 2).poses.back().stamp, 250000000);
  // As other systems write text.
  EXPECT_EQ(loadDrive(good,
                      write("bom.txt",
                            "\xEF\xBB\xBF"
                            "5\r\n5.25\r\n6\r\n"),
                      2)
                .poses.back()
                .stamp,
            250000000);
  EXPECT_EQ(loadDrive(good, write("cr.txt", "5\r5.25\r6\r"), 2).poses.back().stamp, 250000000);
}

TEST(Footprints, OverlapOnlyWhenTheyShareGround) {
  const Footprint square{0.0, 0.0, 0.0, 1.0, 2.0, 2.0};
  const double c = std::sqrt(0.5);
  EXPECT_TRUE(square.overlaps({3.0, 0.0, c, c, 1.0, 1.0}));
  EXPECT_FALSE(square.overlaps({3.0, 3.0, c, c, 1.0, 1.0}));  // their bounding boxes do overlap
  FootprintIndex taken;
  taken.add(square);
  EXPECT_FALSE(taken.isFree({3.9, 0.0, 0.0, 1.0, 2.0, 2.0}));
  EXPECT_TRUE(taken.isFree({4.1, 0.0, 0.0, 1.0, 2.0, 2.0}));
}

/// Any surface higher than the kerb within the clearance of an axis stands on the road.
void expectFreeRoad(const Town& town) {
  for (const Town::Chunk& chunk : town.chunks())
    for (const MeshTriangle& triangle : chunk.triangles) {
      const Eigen::Vector3f middle =
          (triangle.corner[0].position + triangle.corner[1].position + triangle.corner[2].position) / 3.0F;
      const double height = -middle.y() - town.roads().height(middle.x(), middle.z());
      if (height < 0.3 || height > 2.2) continue;
      ASSERT_GT(town.roads().distance(middle.x(), middle.z()), 3.5)
          << "at " << middle.transpose() << ", " << height << " m above the road";
    }
}

TEST(Town, NothingStandsOnTheRoad) { expectFreeRoad(TownFixture().town); }

TEST(Town, NothingStandsOnTheRoadsOfKitti) {
  const char* const data = std::getenv("RATSLAM_DATA");
  const std::filesystem::path folder =
      std::filesystem::path(data != nullptr ? data : RATSLAM_SOURCE_DIR "/../shared/data") / "kitti_gt";
  if (!std::filesystem::exists(folder / "00.txt")) GTEST_SKIP() << "no trajectories in " << folder;
  for (const char* sequence : {"00.txt", "02.txt"}) {
    Drive drive = loadDrive(folder / sequence, "", 0);
    const Town town(drive.roads, 1);
    expectFreeRoad(town);
    settleOnRoad(drive, town.roads());
    double farthest = 0.0;
    for (const DrivePose& pose : drive.poses) {
      const Eigen::Vector3d& place = pose.T_world_camera.translation();
      farthest = std::max(farthest,
                          std::abs(-place.y() - town.roads().height(place.x(), place.z()) - kCameraHeight));
    }
    EXPECT_LT(farthest, 0.25) << sequence << ": the camera leaves its height above the road";
  }
}

}  // namespace
}  // namespace ratslam
