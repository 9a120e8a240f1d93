/// Accuracy of the default map on recorded drives: it must not spoil good odometry, and must mend bad one.
#include <gtest/gtest.h>

#include "recorded_drive.h"

namespace ratslam {
namespace {

TEST(RecordedMap, Explore) {
  const auto drive = readReferenceDrive();
  if (drive.empty()) GTEST_SKIP() << "no reference run in " << dataFolder();
  const Eigen::Matrix3Xd truth = readKittiPositions(dataFolder() + "/kitti_00/poses.txt");
  ExperienceMapParams params;
  ExperienceMap map(params);
  run(map, drive);
  map.settle();
  std::printf("final %f online %f\n", meanApe(positionsOf(map.finalTrajectory()), truth),
              meanApe(positionsOf(map.onlineTrajectory()), truth));
  params.exp_solver = "relaxation";
  params.exp_loops = 20;
  ExperienceMap plain(params);
  run(plain, drive);
  std::printf("plain final %f online %f\n", meanApe(positionsOf(plain.finalTrajectory()), truth),
              meanApe(positionsOf(plain.onlineTrajectory()), truth));
}

}  // namespace
}  // namespace ratslam
