/// OpenRatSLAM's estimates and decisions over 1700 frames of a real drive.
#include <gtest/gtest.h>

#include <cmath>

#include "ratslam/common/stamp.h"
#include "ratslam/pose_cells/pose_cells.h"
#include "reference_data.h"

namespace ratslam {
namespace {

TEST(PoseCellsReference, EstimatesAndActionsOfARealDrive) {
  const std::string folder = referenceFolder();
  const Table odometry = readTable(folder + "/odometry.csv");
  const Table views = readTable(folder + "/local_view_forward.csv");
  const Table expected = readTable(folder + "/pose_cells.csv");
  if (odometry.empty() || views.empty() || expected.empty())
    GTEST_SKIP() << "no reference data in " << folder;
  ASSERT_EQ(odometry.size(), 1700U);
  ASSERT_EQ(views.size(), odometry.size());
  ASSERT_EQ(expected.size(), odometry.size());

  const PoseCellParams params = referenceParams();
  PoseCells pose_cells(params);
  for (std::size_t frame = 0; frame < odometry.size(); ++frame) {
    if (frame > 0) {
      const double dt =
          secondsBetween(stampFromSeconds(odometry[frame - 1][1]), stampFromSeconds(odometry[frame][1]));
      pose_cells.integrate(odometry[frame][2] * dt, odometry[frame][3] * dt);
    }
    ViewEvent view;
    view.stamp = stampFromSeconds(odometry[frame][1]);
    view.id = static_cast<std::uint32_t>(views[frame][1]);
    view.relative_rad = views[frame][3];
    pose_cells.activate(view);
    const TopologicalAction action = frame > 0 ? pose_cells.decide() : TopologicalAction{};

    const std::vector<double>& row = expected[frame];
    const PoseCellEstimate estimate = pose_cells.estimate();
    ASSERT_NEAR(std::remainder(estimate.y - row[1], params.n_xy), 0.0, 1e-6) << "frame " << frame;
    ASSERT_NEAR(std::remainder(estimate.x - row[2], params.n_xy), 0.0, 1e-6) << "frame " << frame;
    ASSERT_NEAR(std::remainder(estimate.th - row[3], params.n_th), 0.0, 1e-6) << "frame " << frame;
    ASSERT_EQ(static_cast<double>(action.kind), row[4]) << "frame " << frame;
    ASSERT_EQ(action.src_id, row[5]) << "frame " << frame;
    ASSERT_EQ(action.dest_id, row[6]) << "frame " << frame;
    ASSERT_EQ(action.stamp, frame > 0 ? view.stamp : 0);
  }
  EXPECT_EQ(pose_cells.reseeds(), 0U);
}

}  // namespace
}  // namespace ratslam
