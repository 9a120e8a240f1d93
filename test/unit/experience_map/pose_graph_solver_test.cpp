/// The sliced solver against the batch solution of the same energy.
#include "ratslam/experience_map/solver/pose_graph_solver.h"

#include <gtest/gtest.h>

#include <limits>

#include "oracle/driven_pose_graph.h"
#include "oracle/experience_map_oracle.h"

namespace ratslam {
namespace {

constexpr std::int64_t kUnlimited = std::numeric_limits<std::int64_t>::max();
constexpr double kTolerance = 1e-8;

/// The pose graph of a drive, its nodes dead-reckoned: the solver has not touched it.
PoseGraph graphOf(const std::vector<DriveStep>& drive, const ExperienceMapParams& params) {
  DrivenPoseGraph driven(params);
  for (const DriveStep& step : drive) driven.take(step);
  return driven.solver.poseGraph();
}

double largestDistance(const std::vector<MapPose>& a, const std::vector<MapPose>& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    largest = std::max(largest, std::hypot(a[k].x - b[k].x, a[k].y - b[k].y, a[k].z - b[k].z));
  }
  return largest;
}

CityDrive noisyCity() {
  CityDrive city;
  city.experiences = 500;
  city.blocks = 2;
  city.recall_share = 0.3;
  city.length_noise = 0.02;
  city.yaw_noise = 0.002;
  city.scale_walk = 0.003;
  return city;
}

struct Unknowns {
  bool scale;
  bool height;
};

class SolverWith : public testing::TestWithParam<Unknowns> {};

TEST_P(SolverWith, EndsAtTheOptimumOfTheBatch) {
  ExperienceMapParams params;
  params.exp_scale = GetParam().scale;
  params.exp_height = GetParam().height;
  std::vector<DriveStep> drive = simulate(noisyCity());
  if (params.exp_height) {
    for (std::size_t k = 1; k < drive.size(); ++k)
      drive[k].motion.up = 0.01 * std::sin(0.05 * static_cast<double>(k));
  }
  PoseGraph graph = graphOf(drive, params);
  const std::vector<MapPose> start = graph.nodes();
  PoseGraphSolver solver(params.exp_scale, params.exp_height, kTolerance);
  solver.advance(graph, kUnlimited);
  ASSERT_TRUE(solver.settled(graph));
  EXPECT_GT(largestDistance(start, graph.nodes()), 0.5);
  const auto batch = solveBatch(graph, start, params.exp_scale, params.exp_height, params.exp_recall_kernel);
  EXPECT_LT(largestDistance(batch, graph.nodes()), 1e-6);
}

INSTANTIATE_TEST_SUITE_P(ScaleAndHeight, SolverWith,
                         testing::Values(Unknowns{false, false}, Unknowns{true, false}, Unknowns{false, true},
                                         Unknowns{true, true}));

TEST(PoseGraphSolver, SlicesNeverRaiseTheEnergyAndEndAtTheSameOptimum) {
  ExperienceMapParams params;
  params.exp_scale = true;
  PoseGraph whole = graphOf(simulate(noisyCity()), params);
  PoseGraph sliced = whole;
  PoseGraphSolver at_once(true, false, kTolerance);
  at_once.advance(whole, kUnlimited);

  PoseGraphSolver in_slices(true, false, kTolerance);
  double energy = sliced.energy(sliced.nodes());
  int slices = 0;
  for (; !in_slices.settled(sliced); ++slices) {
    ASSERT_LT(slices, 100000);
    in_slices.advance(sliced, 500);
    const double now = sliced.energy(sliced.nodes());
    ASSERT_LE(now, energy);
    energy = now;
  }
  EXPECT_GT(slices, 50);
  EXPECT_EQ(largestDistance(whole.nodes(), sliced.nodes()), 0.0);
}

/// Ordering and stepping are done in one go; what they take beyond a slice's work, later slices go without.
TEST(PoseGraphSolver, SlicesOfHalfTheWorkAreTwiceAsMany) {
  const PoseGraph drive = graphOf(simulate(noisyCity()), ExperienceMapParams{});
  const auto slicesOf = [&drive](std::int64_t work) {
    PoseGraph graph = drive;
    PoseGraphSolver solver(false, false, kTolerance);
    int slices = 0;
    for (; !solver.settled(graph); ++slices) solver.advance(graph, work);
    return slices;
  };
  const int slices = slicesOf(1000);
  EXPECT_GT(slices, 50);
  EXPECT_NEAR(slicesOf(500), 2 * slices, 3);
}

TEST(PoseGraphSolver, CarriesAlongWhatGrowsWhileItWorks) {
  const ExperienceMapParams params;
  const std::vector<DriveStep> drive = simulate(noisyCity());
  const PoseGraph complete = graphOf(drive, params);

  // The same graph, fed node by node while slices of work are done.
  PoseGraph growing(params.exp_recall_kernel);
  PoseGraphSolver solver(false, false, kTolerance);
  growing.addNode(complete.nodes()[0]);
  for (const Constraint& constraint : complete.constraints()) {
    if (constraint.to == growing.nodes().size()) {
      growing.addNode(compose(growing.nodes()[constraint.from], constraint.measured));
    }
    growing.addConstraint(constraint);
    const double before = growing.energy(growing.nodes());
    solver.advance(growing, 700);
    ASSERT_LE(growing.energy(growing.nodes()), before * (1.0 + 1e-12));
  }
  solver.advance(growing, kUnlimited);
  ASSERT_TRUE(solver.settled(growing));
  EXPECT_LT(largestDistance(solveBatch(growing, growing.nodes(), false, false, params.exp_recall_kernel),
                            growing.nodes()),
            1e-6);
}

/// Two laps of a ring of 2000 m whose odometry turns too little: the second lap starts about 300 m beside the
/// first.
TEST(PoseGraphSolver, ClosesAJumpOfThreeHundredMetres) {
  constexpr int kLap = 1000;
  constexpr int kRecalls = 60;
  const auto drive = simulateRing(kLap, kLap + kRecalls, 2.0, -0.17);
  ExperienceMapParams params;
  params.exp_rotation_sigma = 0.02;
  PoseGraph graph = graphOf(drive, params);
  const auto gap = [&] {
    return std::hypot(graph.nodes()[kLap].x - graph.nodes()[0].x, graph.nodes()[kLap].y - graph.nodes()[0].y);
  };
  ASSERT_GT(gap(), 300.0);
  const std::vector<MapPose> start = graph.nodes();
  PoseGraphSolver solver(false, false, kTolerance);
  int slices = 0;
  for (double energy = graph.energy(graph.nodes()); !solver.settled(graph); ++slices) {
    ASSERT_LT(slices, 10000);
    solver.advance(graph, 20000);
    ASSERT_LE(graph.energy(graph.nodes()), energy);
    energy = graph.energy(graph.nodes());
  }
  EXPECT_LT(gap(), 1.0);
  EXPECT_LT(largestDistance(solveBatch(graph, start, false, false, params.exp_recall_kernel), graph.nodes()),
            1e-6);
}

/// A drive through a city of 20,000 places, about 12% of whose links are recalls, with odometry so bad that
/// the places recalled lie up to some 500 m from where it puts the robot.
TEST(PoseGraphSolver, EndsAtTheOptimumOfTheBatchOnALargeMapWithLargeClosures) {
  CityDrive city;
  city.experiences = 20000;
  city.blocks = 11;
  city.recall_share = 0.28;
  city.length_noise = 0.01;
  city.yaw_noise = 0.01;
  ExperienceMapParams params;
  params.exp_rotation_sigma = 0.02;
  PoseGraph graph = graphOf(simulate(city), params);
  const std::vector<MapPose> start = graph.nodes();
  double recalls = 0.0;
  double farthest = 0.0;
  for (const Constraint& constraint : graph.constraints()) {
    if (!constraint.recall) continue;
    recalls += 1.0;
    const MapPose& from = start[constraint.from];
    const MapPose& to = start[constraint.to];
    farthest = std::max(farthest, std::hypot(to.x - from.x, to.y - from.y));
  }
  EXPECT_NEAR(recalls / static_cast<double>(graph.constraints().size()), 0.12, 0.01);
  EXPECT_GT(farthest, 300.0);
  PoseGraphSolver solver(false, false, kTolerance);
  solver.advance(graph, kUnlimited);
  ASSERT_TRUE(solver.settled(graph));
  const auto batch = solveBatch(graph, start, false, false, params.exp_recall_kernel);
  EXPECT_LT(largestDistance(batch, graph.nodes()), 1e-6);
}

TEST(PoseGraphSolver, HasNothingToDoWithoutRecalls) {
  CityDrive city = noisyCity();
  city.recall_share = 0.0;
  PoseGraph graph = graphOf(simulate(city), ExperienceMapParams{});
  PoseGraphSolver solver(false, false, kTolerance);
  EXPECT_TRUE(solver.settled(graph));
  EXPECT_FALSE(solver.advance(graph, kUnlimited));
}

}  // namespace
}  // namespace ratslam
