/// Invariants of the network, whatever comes in.
#include "ratslam/pose_cells/network.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "against_oracle.h"

namespace ratslam {
namespace {

/// Moves a packet and tells how far the estimate went, in cells.
struct Way {
  double x, y, th;
};
Way travelled(PoseCellNetwork& network, double distance, double rotation, int steps) {
  Way way{0.0, 0.0, 0.0};
  const ActivityGrid& grid = network.activity();
  for (int step = 0; step < steps; ++step) {
    const PoseCellEstimate before = network.estimate();
    network.step(distance, rotation);
    const PoseCellEstimate& after = network.estimate();
    way.x += std::remainder(after.x - before.x, grid.nXy());
    way.y += std::remainder(after.y - before.y, grid.nXy());
    way.th += std::remainder(after.th - before.th, grid.nTh());
  }
  return way;
}

TEST(PoseCellNetwork, StartsInTheCentreCell) {
  const PoseCellNetwork network(sized(21, 36));
  EXPECT_EQ(network.activity().at({10, 10, 18}), 1.0);
  EXPECT_EQ(network.activity().sum(), 1.0);
  EXPECT_EQ(network.estimate().x, 10.0);
  EXPECT_EQ(network.estimate().th, 18.0);
}

TEST(PoseCellNetwork, FollowsTheOdometry) {
  PoseCellParams params = sized(21, 36);
  params.cell_size = 2.0;
  PoseCellNetwork network(params);
  // Layer 18 of 36 faces backwards along x: 30 m are 15 cells.
  const Way straight = travelled(network, 0.6, 0.0, 50);
  EXPECT_NEAR(straight.x, -15.0, 0.8);
  EXPECT_NEAR(straight.y, 0.0, 0.1);
  const Way back = travelled(network, -0.6, 0.0, 50);
  EXPECT_NEAR(back.x, 15.0, 0.8);
  // Counter-clockwise, to higher layers: five whole turns.
  const Way turned = travelled(network, 0.0, 0.1, 314);
  EXPECT_NEAR(turned.th, 314 * 0.1 * 36 / (2.0 * kPi), 2.0);
}

TEST(PoseCellNetwork, APathOfWholeCellsMovesTheActivityUnchanged) {
  PoseCellParams params = sized(12, 8);
  params.openratslam_corner = false;
  PoseCellNetwork network(params);
  ActivityGrid grid(12, 8);
  grid.add({11, 3, 0}, 0.75);  // heading 0, towards higher columns, over the edge
  grid.add({4, 10, 2}, 0.25);  // heading pi / 2, towards higher rows
  network.setActivity(grid);
  network.integratePath(3.0, 3.0 * kPi / 4.0 + 4.0 * kPi);  // three layers and two whole turns
  EXPECT_NEAR(network.activity().at({2, 3, 3}), 0.75, 1e-12);
  EXPECT_NEAR(network.activity().at({4, 1, 5}), 0.25, 1e-12);
}

class PathIntegration : public testing::TestWithParam<double> {};

TEST_P(PathIntegration, ConservesActivity) {
  for (const bool corner : {false, true}) {
    PoseCellParams params = sized(9, 10);
    params.openratslam_corner = corner;
    PoseCellNetwork network(params);
    for (int step = 0; step < 40; ++step) network.integratePath(GetParam(), 0.7 * step);
    EXPECT_NEAR(network.activity().sum(), 1.0, 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Distances, PathIntegration,
                         testing::Values(0.0, 0.37, -0.37, 1.0, -1.0, 2.5, 8.0, 9.0, -33.3, 1e6 + 0.5,
                                         1e300));

TEST(PathIntegration, ManySubStepsEqualThemOneByOne) {
  PoseCellParams params = sized(9, 10);
  params.openratslam_corner = false;
  PoseCellNetwork at_once(params);
  PoseCellNetwork one_by_one(params);
  at_once.integratePath(23.7, 0.0);
  for (int step = 0; step < 24; ++step) one_by_one.integratePath(23.7 / 24, 0.0);
  for (int k = 0; k < 10; ++k)
    for (int j = 0; j < 9; ++j)
      for (int i = 0; i < 9; ++i)
        EXPECT_NEAR(at_once.activity().at({i, j, k}), one_by_one.activity().at({i, j, k}), 1e-13);
}

TEST(PoseCellNetwork, StaysSoundWhateverComesIn) {
  for (const auto& [n_xy, n_th] : {std::pair{1, 1}, {1, 9}, {2, 3}, {7, 5}, {21, 36}}) {
    PoseCellNetwork network(sized(n_xy, n_th));
    for (const double distance : {0.0, 0.5, -0.5, 7.3, -1000.0, 1e18, -1e300, 5e-324})
      for (const double rotation : {0.0, 0.1, -0.1, 20.0, -1e5, 1e300, -5e-324}) {
        network.step(distance, rotation);
        network.inject({n_xy - 1, 0, n_th / 2}, 0.2);
        expectSound(network);
      }
  }
}

TEST(PoseCellNetwork, StrongInjectionMovesTheEstimate) {
  PoseCellNetwork network(sized(21, 36));
  for (int step = 0; step < 10; ++step) network.step(0.0, 0.0);
  for (int step = 0; step < 10; ++step) {
    network.inject({3, 17, 30}, 0.3);
    network.step(0.0, 0.0);
  }
  EXPECT_NEAR(network.estimate().x, 3.0, 0.2);
  EXPECT_NEAR(network.estimate().y, 17.0, 0.2);
  EXPECT_NEAR(network.estimate().th, 30.0, 0.2);
}

TEST(PoseCellNetwork, ActivityInjectedBetweenCellsDrawsTheEstimateThere) {
  for (const PoseCellEstimate& where :
       {PoseCellEstimate{3.8, 17.3, 30.6}, PoseCellEstimate{20.7, 0.4, 35.9}}) {
    PoseCellNetwork network(sized(21, 36));
    for (int step = 0; step < 30; ++step) {
      network.injectAt(where, 0.3);
      network.step(0.0, 0.0);
    }
    EXPECT_NEAR(std::remainder(network.estimate().x - where.x, 21.0), 0.0, 0.1);
    EXPECT_NEAR(std::remainder(network.estimate().y - where.y, 21.0), 0.0, 0.1);
    EXPECT_NEAR(std::remainder(network.estimate().th - where.th, 36.0), 0.0, 0.1);
  }
}

TEST(PoseCellNetwork, AtACellAllActivityGoesThere) {
  PoseCellNetwork network(sized(21, 36));
  PoseCellNetwork other(sized(21, 36));
  network.inject({20, 3, 35}, 0.3);
  other.injectAt({20.0, 3.0, 35.0}, 0.3);
  const double energy = network.activity().at({20, 3, 35});
  EXPECT_GT(energy, 0.2);
  EXPECT_EQ(other.activity().at({20, 3, 35}), energy);
  EXPECT_EQ(other.activity().at({0, 3, 35}), network.activity().at({0, 3, 35}));
}

TEST(PoseCellNetwork, DeadActivityStartsAgainAtTheEstimateAndGoesOn) {
  PoseCellParams params = sized(21, 36);
  params.global_inhibition = 0.9;
  PoseCellNetwork network(params);
  const Way way = travelled(network, 0.25, 0.0, 20);
  expectSound(network);
  EXPECT_EQ(network.reseeds(), 20U);
  EXPECT_NEAR(way.x, -5.0, 0.1);
}

TEST(PoseCellNetwork, RefusesMotionThatIsNotFinite) {
  PoseCellNetwork network(sized(21, 36));
  network.step(0.4, 0.1);
  const ActivityGrid before = network.activity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -infinity}) {
    EXPECT_THROW(network.step(bad, 0.0), std::invalid_argument);
    EXPECT_THROW(network.step(0.0, bad), std::invalid_argument);
    EXPECT_THROW(network.integratePath(bad, 0.0), std::invalid_argument);
  }
  for (std::size_t c = 0; c < before.offset(36, 0); ++c)
    ASSERT_EQ(network.activity().data()[c], before.data()[c]);
}

TEST(PoseCellNetwork, RefusesActivityThatIsNone) {
  PoseCellNetwork network(sized(4, 4));
  EXPECT_THROW(network.setActivity(ActivityGrid(5, 4)), std::invalid_argument);
  EXPECT_THROW(network.setActivity(ActivityGrid(4, 4)), std::invalid_argument);
  ActivityGrid negative(4, 4);
  negative.add({0, 0, 0}, 1.0);
  negative.add({1, 0, 0}, -0.5);
  EXPECT_THROW(network.setActivity(negative), std::invalid_argument);
}

TEST(PoseCellParams, BadValuesAreNamed) {
  const auto message = [](auto change) -> std::string {
    PoseCellParams params;
    change(params);
    try {
      PoseCellNetwork network(params);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(message([](PoseCellParams&) {}), "");
  EXPECT_EQ(message([](PoseCellParams& p) { p.n_xy = 0; }).rfind("pc_dim_xy: value 0 is not allowed: ", 0),
            0U);
  EXPECT_EQ(message([](PoseCellParams& p) { p.excitation_dim = 4; }).rfind("pc_w_e_dim: value 4", 0), 0U);
  EXPECT_EQ(message([](PoseCellParams& p) { p.cell_size = -1.0; }).rfind("pc_cell_x_size: value -1", 0), 0U);
  EXPECT_EQ(message([](PoseCellParams& p) { p.restore = std::nan(""); }).rfind("pc_vt_restore: value nan", 0),
            0U);
  EXPECT_EQ(message([](PoseCellParams& p) { p.n_xy = p.n_th = 4096; }).rfind("pc_dim_xy: value 4096", 0), 0U);
}

}  // namespace
}  // namespace ratslam
