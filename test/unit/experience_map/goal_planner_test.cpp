#include "ratslam/experience_map/goal_planner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

#include "ratslam/experience_map/experience_map.h"

namespace ratslam {
namespace {

constexpr Stamp kSecond = 1000000000;

void join(ExperienceGraph& graph, std::uint32_t from, std::uint32_t to, double seconds) {
  Link link;
  link.from = from;
  link.to = to;
  link.duration_s = seconds;
  graph.addLink(link);
}

/// Experiences 0..n-1 at x = 0, 10, 20, ...
ExperienceGraph row(std::uint32_t experiences) {
  ExperienceGraph graph;
  for (std::uint32_t id = 0; id < experiences; ++id)
    graph.addExperience(MapPose{10.0 * id, 0.0, 0.0, 0.0, 0.0});
  return graph;
}

TEST(GoalPlanner, TakesTheQuickestWayInEitherDirection) {
  ExperienceGraph graph = row(4);
  join(graph, 0, 3, 10.0);  // direct, slow
  join(graph, 1, 0, 2.0);   // driven the other way
  join(graph, 1, 2, 2.0);
  join(graph, 3, 2, 2.0);
  GoalPlanner planner(1.0, 100.0);
  EXPECT_EQ(planner.setGoal(graph, 30.4, 0.0, 0, 0).status, GoalStatus::kActive);
  EXPECT_EQ(planner.goal().experience, 3U);
  EXPECT_NEAR(planner.goal().distance, 0.4, 1e-12);
  EXPECT_EQ(planner.path(0), (std::vector<std::uint32_t>{0, 1, 2, 3}));
}

TEST(GoalPlanner, LinksThatComeLaterGiveTheTimesOfAFreshSearch) {
  std::mt19937 random(3);
  constexpr std::uint32_t kExperiences = 60;
  ExperienceGraph graph = row(kExperiences);
  for (std::uint32_t id = 0; id + 1 < kExperiences; ++id) join(graph, id, id + 1, 5.0);
  GoalPlanner grown(1.0, 1e6);
  grown.setGoal(graph, 100.0, 0.0, 0, 0);
  const auto seconds = [&](const std::vector<std::uint32_t>& path) {
    double sum = 0.0;
    for (std::size_t k = 0; k + 1 < path.size(); ++k) {
      double best = std::numeric_limits<double>::infinity();
      graph.forEachLinkOf(path[k], [&](std::uint32_t link) {
        const Link& l = graph.links()[link];
        if (l.from == path[k + 1] || l.to == path[k + 1]) best = std::min(best, l.duration_s);
      });
      sum += best;
    }
    return sum;
  };
  for (int k = 0; k < 30; ++k) {
    const auto from = static_cast<std::uint32_t>(random() % kExperiences);
    const auto to = static_cast<std::uint32_t>(random() % kExperiences);
    if (from == to) continue;
    join(graph, from, to, 1.0 + static_cast<double>(random() % 30));
    grown.update(graph, 0, 0);
    GoalPlanner fresh(1.0, 1e6);
    fresh.setGoal(graph, 100.0, 0.0, 0, 0);
    for (std::uint32_t id = 0; id < kExperiences; ++id) {
      ASSERT_DOUBLE_EQ(seconds(grown.path(id)), seconds(fresh.path(id)));
    }
  }
}

TEST(GoalPlanner, IsDoneWhenTheRobotArrives) {
  ExperienceGraph graph = row(3);
  join(graph, 0, 1, 1.0);
  join(graph, 1, 2, 1.0);
  GoalPlanner planner(1.0, 100.0);
  planner.setGoal(graph, 20.0, 0.0, 0, 0);
  EXPECT_EQ(planner.update(graph, 1, kSecond).status, GoalStatus::kActive);
  EXPECT_EQ(planner.update(graph, 2, 2 * kSecond).status, GoalStatus::kReached);
  EXPECT_EQ(planner.path(2), (std::vector<std::uint32_t>{2}));
}

TEST(GoalPlanner, SaysWhyItFails) {
  ExperienceGraph graph = row(3);
  join(graph, 0, 1, 1.0);
  GoalPlanner planner(1.0, 10.0);
  EXPECT_EQ(planner.setGoal(ExperienceGraph{}, 0.0, 0.0, 0, 0).message, "the map is still empty");
  EXPECT_EQ(planner.setGoal(graph, 5.0, 0.0, 0, 0).message,
            "the goal (5, 0) is 5 m from the nearest experience, more than 1 m");
  EXPECT_EQ(planner.setGoal(graph, 20.0, 0.0, 0, 0).message,
            "no links lead from experience 0 to experience 2");
  EXPECT_EQ(planner.setGoal(graph, std::numeric_limits<double>::quiet_NaN(), 0.0, 0, 0).message,
            "the goal is not a finite place");
  EXPECT_EQ(planner.goal().status, GoalStatus::kFailed);
  EXPECT_TRUE(planner.path(0).empty());

  EXPECT_EQ(planner.setGoal(graph, 10.0, 0.0, 0, 5 * kSecond).status, GoalStatus::kActive);
  EXPECT_EQ(planner.update(graph, 0, 15 * kSecond).status, GoalStatus::kActive);
  EXPECT_EQ(planner.update(graph, 0, 16 * kSecond).status, GoalStatus::kFailed);
  EXPECT_EQ(planner.goal().message, "experience 1 was not reached within 10 s");
}

TEST(GoalPlanner, PathInTheMapStartsAtTheRobot) {
  ExperienceMap map{ExperienceMapParams{}};
  EXPECT_EQ(map.setGoal(0.0, 0.0).status, GoalStatus::kFailed);
  map.start(0);
  OdometryStep step;
  step.forward = 2.0;
  for (std::uint32_t k = 0; k < 5; ++k) {
    map.integrate((k + 1) * kSecond, step);
    TopologicalAction create;
    create.kind = ActionKind::kCreateNode;
    create.src_id = k == 0 ? 0 : k - 1;
    create.dest_id = k;
    map.apply(create);
  }
  map.integrate(6 * kSecond, step);
  const MapPose first = map.graph().pose(0);
  ASSERT_EQ(map.setGoal(first.x, first.y).status, GoalStatus::kActive);
  const auto path = map.pathToGoal();
  ASSERT_EQ(path.size(), 6U);
  EXPECT_EQ(path.front().y, map.robotPose().y);
  EXPECT_EQ(path.back().y, first.y);
}

}  // namespace
}  // namespace ratslam
