#include "ratslam/experience_map/solver/relaxation.h"

#include <gtest/gtest.h>

#include "oracle/experience_map_drive.h"
#include "oracle/experience_map_oracle.h"

namespace ratslam {
namespace {

/// The graph of a noisy drive that has not been relaxed yet.
ExperienceGraph unrelaxedGraph(unsigned seed) {
  CityDrive city;
  city.experiences = 600;
  city.blocks = 2;
  city.recall_share = 0.3;
  city.length_noise = 0.05;
  city.yaw_noise = 0.02;
  city.seed = seed;
  ExperienceMapParams params;
  params.exp_solver = "relaxation";
  params.exp_loops = 0;
  ExperienceMap map(params);
  run(map, simulate(city));
  return map.graph();
}

class RelaxationOfDrive : public testing::TestWithParam<unsigned> {};

TEST_P(RelaxationOfDrive, EqualsThePlainSweepsToTheBit) {
  for (const SimdLevel level : availableSimdLevels()) {
    ExperienceGraph graph = unrelaxedGraph(GetParam());
    OracleRelaxation oracle(graph);
    Relaxation relaxation(7, 0.4, level);
    RobotPlace robot;
    for (int update = 0; update < 5; ++update) {
      relaxation.update(graph, robot);
      oracle.sweep(7, 0.4);
      for (std::uint32_t id = 0; id < graph.experiences().size(); ++id) {
        ASSERT_EQ(graph.pose(id).x, oracle.nodes()[id].x);
        ASSERT_EQ(graph.pose(id).y, oracle.nodes()[id].y);
        ASSERT_EQ(graph.pose(id).yaw, oracle.nodes()[id].th);
      }
    }
  }
}

/// A graph that grows from one place to several blocks of links, with an update and a rest after each.
TEST(Relaxation, EqualsThePlainSweepsWhileTheGraphGrows) {
  ExperienceGraph graph;
  Relaxation relaxation(3, 0.5);
  RobotPlace robot;
  for (std::uint32_t id = 0; id < 200; ++id) {
    MapPose pose;
    pose.x = 0.9 * id;
    pose.yaw = 0.01 * id;
    graph.addExperience(pose);
    Link link;
    link.from = id / 2;
    link.to = id;
    link.distance = 1.0;
    link.heading_rad = 0.3;
    link.facing_rad = id % 3 == 0 ? 3.0 : -0.2;
    if (id > 0) graph.addLink(link);
    OracleRelaxation oracle(graph);
    const int updates = id == 100 ? 400 : 2;
    for (int update = 0; update < updates; ++update) {
      oracle.sweep(3, 0.5);
      relaxation.update(graph, robot);
    }
    for (std::uint32_t node = 0; node <= id; ++node) {
      ASSERT_EQ(graph.pose(node).x, oracle.nodes()[node].x);
      ASSERT_EQ(graph.pose(node).y, oracle.nodes()[node].y);
      ASSERT_EQ(graph.pose(node).yaw, oracle.nodes()[node].th);
    }
  }
}

/// The C library's sine and cosine make another map in the last digits only.
TEST_P(RelaxationOfDrive, IsNextToTheOneWithTheLibrarysSine) {
  const ExperienceGraph graph = unrelaxedGraph(GetParam());
  OracleRelaxation fixed(graph);
  OracleRelaxation library(graph);
  fixed.sweep(100, 0.5);
  library.sweep(100, 0.5, LibrarySineCosine());
  for (std::size_t id = 0; id < graph.experiences().size(); ++id) {
    ASSERT_NEAR(fixed.nodes()[id].x, library.nodes()[id].x, 1e-10);
    ASSERT_NEAR(fixed.nodes()[id].y, library.nodes()[id].y, 1e-10);
    ASSERT_EQ(fixed.nodes()[id].th, library.nodes()[id].th);
  }
}

TEST_P(RelaxationOfDrive, DescendsItsEnergy) {
  ExperienceGraph graph = unrelaxedGraph(GetParam());
  Relaxation relaxation(100, 0.5);
  RobotPlace robot;
  const double before = OracleRelaxation(graph).energy();
  relaxation.update(graph, robot);
  EXPECT_LT(OracleRelaxation(graph).energy(), 0.5 * before);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RelaxationOfDrive, testing::Values(1U, 2U, 3U));

TEST(Relaxation, LeavesTheRobotsHeadingInTheMapAlone) {
  ExperienceGraph graph = unrelaxedGraph(4);
  Relaxation relaxation(20, 0.5);
  RobotPlace robot{300, Motion{}};
  robot.motion.pose.yaw = 0.25;
  const double before = wrapAngle(graph.pose(300).yaw + robot.motion.pose.yaw);
  relaxation.update(graph, robot);
  EXPECT_NE(robot.motion.pose.yaw, 0.25);
  EXPECT_NEAR(wrapAngle(graph.pose(300).yaw + robot.motion.pose.yaw - before), 0.0, 1e-12);
}

}  // namespace
}  // namespace ratslam
