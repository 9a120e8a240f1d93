#include "ratslam/experience_map/solver/pose_graph.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "oracle/experience_map_drive.h"
#include "oracle/experience_map_oracle.h"
#include "ratslam/experience_map/solver/pose_graph_solver.h"

namespace ratslam {
namespace {

MapPose randomPose(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  return {10.0 * uniform(random), 10.0 * uniform(random), uniform(random), 3.0 * uniform(random),
          0.5 * uniform(random)};
}

Constraint randomConstraint(std::mt19937& random, bool recall) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Constraint constraint;
  constraint.from = 0;
  constraint.to = 1;
  constraint.measured = {uniform(random), uniform(random), uniform(random), uniform(random)};
  constraint.xy_weight << 3.0, 0.5, -1.0, 2.0;
  constraint.xy_by_yaw = {0.3, -0.7};
  constraint.yaw_weight = 30.0;
  constraint.scale_weight = 100.0;
  constraint.z_weight = 4.0;
  constraint.recall = recall;
  return constraint;
}

class PoseGraphJacobian : public testing::TestWithParam<bool> {};

TEST_P(PoseGraphJacobian, EqualsTheNumericalOne) {
  std::mt19937 random(5);
  for (int trial = 0; trial < 20; ++trial) {
    const MapPose from = randomPose(random);
    const MapPose to = randomPose(random);
    const Constraint constraint = randomConstraint(random, GetParam());
    const LinearisedConstraint linear = PoseGraph::linearise(constraint, from, to);
    constexpr double kStep = 1e-6;
    for (int column = 0; column < 5; ++column) {
      const auto moved = [column](MapPose pose, double by) {
        double* const values[] = {&pose.x, &pose.y, &pose.yaw, &pose.log_scale, &pose.z};
        *values[column] += by;
        return pose;
      };
      const Residual by_from = (PoseGraph::residual(constraint, moved(from, kStep), to) -
                                PoseGraph::residual(constraint, moved(from, -kStep), to)) /
                               (2.0 * kStep);
      const Residual by_to = (PoseGraph::residual(constraint, from, moved(to, kStep)) -
                              PoseGraph::residual(constraint, from, moved(to, -kStep))) /
                             (2.0 * kStep);
      // A facing at the wrap of the angle has no derivative; random poses keep clear of it.
      EXPECT_LT((linear.by_from.col(column) - by_from).norm(), 1e-6) << "column " << column;
      EXPECT_LT((linear.by_to.col(column) - by_to).norm(), 1e-6) << "column " << column;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(OdometryAndRecall, PoseGraphJacobian, testing::Bool());

TEST(PoseGraph, EqualWeightsGiveTheEnergyOfEquationSix) {
  CityDrive city;
  city.experiences = 300;
  city.recall_share = 0.5;
  city.blocks = 1;
  city.length_noise = 0.05;
  city.yaw_noise = 0.02;
  ExperienceMapParams params;
  params.exp_solver = "relaxation";
  params.exp_loops = 1;
  ExperienceMap map(params);
  run(map, simulate(city));

  PoseGraph graph(1.0);
  for (const Experience& experience : map.graph().experiences()) graph.addNode(experience.pose);
  for (const Link& link : map.graph().links()) {
    Constraint constraint;
    constraint.from = link.from;
    constraint.to = link.to;
    constraint.measured = {link.distance * std::cos(link.heading_rad),
                           link.distance * std::sin(link.heading_rad), 0.0, link.facing_rad};
    graph.addConstraint(constraint);
  }
  const double expected = OracleRelaxation(map.graph()).energy();
  ASSERT_GT(expected, 1e-3);
  EXPECT_NEAR(graph.energy(graph.nodes()), expected, 1e-9 * expected);
}

TEST(PoseGraph, DoubtsARecallTheMoreTheFartherItIsOff) {
  const PoseGraph graph(2.0);
  Constraint recall;
  recall.recall = true;
  EXPECT_NEAR(graph.energy(recall, 1e-4), 1e-4, 1e-8);
  EXPECT_LT(graph.energy(recall, 1e4), 100.0);
  // The pull is weight times residual: it fades for residuals beyond the kernel's width.
  EXPECT_GT(graph.weight(recall, 4.0) * 2.0, graph.weight(recall, 1e4) * 100.0);
  EXPECT_EQ(graph.weight(Constraint{}, 1e4), 1.0);
}

/// Of (x, y, z, yaw): of a way of `length` along x whose turns are a random walk (Brownian motion) that ends with
/// this deviation.
Eigen::Matrix4d wanderedCovariance(double length, double turn) {
  Eigen::Matrix4d covariance = Eigen::Vector4d(0.01, 0.01, 0.04, turn * turn).asDiagonal();
  covariance(1, 1) += length * length * turn * turn / 3.0;
  covariance(1, 3) = covariance(3, 1) = length * turn * turn / 2.0;
  return covariance;
}

TEST(ConstraintWeights, KeepTheCovarianceOfPlaceAndFacing) {
  const Eigen::Matrix4d covariance = wanderedCovariance(20.0, 0.3);
  Constraint constraint;
  weigh(constraint, covariance);
  EXPECT_LT((covarianceOf(constraint) - covariance).norm(), 1e-12 * covariance.norm());

  // The energy of an error is its Mahalanobis distance.
  constraint.measured = {20.0, 0.0, 0.0, 0.0};
  const Eigen::Vector4d error(0.1, 4.0, -0.2, 0.4);
  const MapPose from;
  const MapPose to{20.0 + error[0], error[1], error[2], error[3], 0.0};
  EXPECT_NEAR(PoseGraph::residual(constraint, from, to).squaredNorm(),
              error.dot(covariance.llt().solve(error)), 1e-9);

  // A node that is reached from an exact one is as uncertain, in the axes of the map.
  MapPose turned;
  turned.yaw = M_PI / 2.0;
  constraint.scale_weight = 1e6;
  const Eigen::Matrix4d reached =
      poseCovariance(PoseGraph::propagate(constraint, turned, NodeCovariance::Zero()));
  EXPECT_NEAR(reached(0, 0), covariance(1, 1), 1e-9);
  EXPECT_NEAR(reached(0, 3), -covariance(1, 3), 1e-9);
}

TEST(ConstraintWeights, OfACovarianceThatCannotBeAreFinite) {
  Eigen::Matrix4d covariance = wanderedCovariance(20.0, 0.3);
  covariance(1, 3) = covariance(3, 1) = 100.0;
  Constraint constraint;
  weigh(constraint, covariance);
  EXPECT_TRUE(constraint.xy_weight.allFinite());
  EXPECT_TRUE(constraint.xy_by_yaw.isZero());
}

// A robot drives 25 m unmeasured, assumed straight, then 30 m measured well. A recall shows a turn of 0.8 rad, which
// also moved the robot sideways.
TEST(ConstraintWeights, ARecallShowsWhereAnUnmeasuredTurnHasLed) {
  const double turn = 0.8;
  const double length = 25.0;
  const MapPose turned{length * std::sin(turn) / turn, length * (1.0 - std::cos(turn)) / turn, 0.0, turn,
                       0.0};
  PoseGraph graph(1e3);
  for (int i = 0; i < 3; ++i) graph.addNode(MapPose{});
  graph.nodes()[1] = {length, 0.0, 0.0, 0.0, 0.0};
  graph.nodes()[2] = {length + 30.0, 0.0, 0.0, 0.0, 0.0};
  Constraint unmeasured;
  unmeasured.to = 1;
  unmeasured.measured = {length, 0.0, 0.0, 0.0};
  weigh(unmeasured, wanderedCovariance(length, 0.4));
  Constraint driven;
  driven.from = 1;
  driven.to = 2;
  driven.measured = {30.0, 0.0, 0.0, 0.0};
  driven.xy_weight *= 10.0;
  driven.yaw_weight = 10.0;
  Constraint recall;  // which measures only the facing
  recall.to = 2;
  recall.recall = true;
  recall.measured = {0.0, 0.0, 0.0, turn};
  recall.xy_weight *= 1e-6;
  recall.yaw_weight = 1e3;
  for (const Constraint& constraint : {unmeasured, driven, recall}) graph.addConstraint(constraint);
  PoseGraphSolver solver(false, false, 1e-9);
  while (!solver.complete(graph)) solver.advance(graph, 1000000);
  const MapPose& found = graph.nodes()[1];
  EXPECT_NEAR(found.yaw, turn, 0.2 * turn);
  EXPECT_NEAR(found.y, turned.y, 0.2 * turned.y);  // a graph that knows of no such tie leaves it at 0
}

TEST(PoseGraph, RefusesConstraintsThatJoinNothing) {
  PoseGraph graph(2.0);
  graph.addNode(MapPose{});
  Constraint constraint;
  constraint.to = 1;
  EXPECT_THROW(graph.addConstraint(constraint), std::invalid_argument);
  constraint.to = 0;
  EXPECT_THROW(graph.addConstraint(constraint), std::invalid_argument);
  EXPECT_TRUE(graph.constraints().empty());
}

}  // namespace
}  // namespace ratslam
