/// A way that nobody measured, with a corner in it: what lies beyond is joined by the recalls that come later.
#include "ratslam/experience_map/solver/rejoin.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "ratslam/common/angles.h"
#include "ratslam/experience_map/experience_map.h"
#include "ratslam/experience_map/solver/pose_graph.h"

namespace ratslam {
namespace {

constexpr Stamp kTick = 100000000;
constexpr int kSide = 25;
constexpr int kLap = 4 * kSide;
constexpr int kSilence = 40;  // steps, with a corner among them

/// Makes a place the current one: an experience that is known is recalled, one that is new is created.
void decide(ExperienceMap& map, Stamp stamp, std::uint32_t& current, std::uint32_t place) {
  TopologicalAction action;
  action.stamp = stamp;
  action.kind = place < map.graph().experiences().size() ? ActionKind::kCreateEdge : ActionKind::kCreateNode;
  action.src_id = current;
  action.dest_id = place;
  map.apply(action);
  current = place;
}

/// Laps of a square of 25 m a side. After the first lap the odometry is silent for kSilence steps; the places of
/// the 10 steps after that are not recalled.
class SilentLap {
 public:
  explicit SilentLap(double loose_place) : map_(params()) {
    map_.start(0);
    for (int k = 1; k <= kLap; ++k) drive(k, static_cast<std::uint32_t>(k - 1));
    OdometryStep unknown;
    unknown.dt = 4.0;
    unknown.bridged = true;
    const Eigen::Vector4d sigmas(loose_place, loose_place, 1.0, kPi);
    unknown.covariance = StepCovariance(sigmas.cwiseAbs2().asDiagonal());
    map_.integrate((kLap + kSilence) * kTick, unknown);
    for (int k = kLap + kSilence + 1; k <= kLap + kSilence + 10; ++k) {
      drive(k, static_cast<std::uint32_t>(map_.graph().experiences().size()));
    }
  }

  /// @param place  experience that is recalled after step k; one that is new is created
  void drive(int k, std::uint32_t place) {
    OdometryStep step;
    step.dt = 0.1;
    step.forward = 1.0;
    step.rotation = k > 1 && k % kSide == 1 ? kPi / 2.0 : 0.0;
    map_.integrate(k * kTick, step);
    decide(map_, k * kTick, current_, place);
  }

  /// Distance of the robot from an experience [m], once all is settled.
  double distanceTo(std::uint32_t place) {
    map_.settle();
    const MapPose& there = map_.graph().pose(place);
    return std::hypot(map_.robotPose().x - there.x, map_.robotPose().y - there.y);
  }

 private:
  static ExperienceMapParams params() {
    ExperienceMapParams p;
    p.exp_initial_em_deg = 0.0;
    return p;
  }

  ExperienceMap map_;
  std::uint32_t current_ = 0;
};

TEST(Rejoin, TheFirstRecallAfterASilenceSaysWhereTheRobotIs) {
  SilentLap lap(30.0);
  for (int k = kLap + kSilence + 11; k <= kLap + kSilence + 15; ++k) {
    lap.drive(k, static_cast<std::uint32_t>((k - 1) % kLap));
    EXPECT_LT(lap.distanceTo(static_cast<std::uint32_t>((k - 1) % kLap)), 0.5) << k;
  }
}

TEST(Rejoin, AWrongRecallIsOutvotedByRightOnes) {
  SilentLap lap(30.0);
  lap.drive(kLap + kSilence + 11, 10);
  int k = kLap + kSilence + 12;
  for (; k <= kLap + kSilence + 17; ++k) lap.drive(k, static_cast<std::uint32_t>((k - 1) % kLap));
  EXPECT_LT(lap.distanceTo(static_cast<std::uint32_t>((k - 2) % kLap)), 0.5);
}

TEST(Rejoin, WhatWasMeasuredIsNotTornByARecall) {
  SilentLap lap(0.05);  // [m]; an odometry that states so small an error is trusted
  const int k = kLap + kSilence + 11;
  lap.drive(k, static_cast<std::uint32_t>((k - 1) % kLap));
  EXPECT_GT(lap.distanceTo(static_cast<std::uint32_t>((k - 1) % kLap)), 20.0);
}

/// A lap of the square; then, an hour later, a new stretch from the middle of its second side, whose first steps were
/// guessed as twice too long until they are corrected.
class NewStretch {
 public:
  static constexpr int kFirst = 36000;  // tick at which it begins
  static constexpr int kBegin = kSide + kSide / 2;
  static constexpr int kGuessed = 5;
  static constexpr int kUnknown = 8;  // steps until something is recalled

  explicit NewStretch(bool corrected_after_recalls) {
    map_.start(0);
    for (int k = 1; k <= kLap; ++k)
      drive(k, 1.0, false, static_cast<std::uint32_t>(k - 1), k > 1 && k % kSide == 1);
    map_.start(kFirst * kTick);
    for (int k = 1; k <= kUnknown; ++k) {
      drive(kFirst + k, k <= kGuessed ? 2.0 : 1.0, k <= kGuessed,
            static_cast<std::uint32_t>(map_.graph().experiences().size()), false);
      if (k == kGuessed + 1 && !corrected_after_recalls) correct(k);
    }
    for (int k = kUnknown + 1; k <= kUnknown + 4; ++k) {
      drive(kFirst + k, 1.0, false, static_cast<std::uint32_t>(kBegin + k - 1), false);
    }
    if (corrected_after_recalls) correct(kGuessed + 1);
    map_.settle();
  }

  /// Distance of the path from where it was driven at a step of the new stretch [m].
  double error(int step) const {
    const auto path = map_.finalTrajectory();
    const auto at = std::find_if(path.begin(), path.end(), [&](const StampedPose& each) {
      return each.stamp == (kFirst + step) * kTick;
    });
    if (at == path.end()) return std::numeric_limits<double>::infinity();
    if (step == 0) {  // half way between two experiences at most
      const MapPose& there = map_.graph().pose(kBegin - 1);
      return std::hypot(at->pose.x - there.x, at->pose.y - there.y);
    }
    const MapPose& there = map_.graph().pose(static_cast<std::uint32_t>(kBegin + step - 1));
    return std::hypot(at->pose.x - there.x, at->pose.y - there.y);
  }

 private:
  void drive(int tick, double forward, bool bridged, std::uint32_t place, bool corner) {
    OdometryStep step;
    step.dt = 0.1;
    step.forward = forward;
    step.rotation = corner ? kPi / 2.0 : 0.0;
    step.bridged = bridged;
    const double sigma = bridged ? 3.0 : 0.01;
    step.covariance = StepCovariance(Eigen::Vector4d(sigma, sigma, 0.01, 1e-3).cwiseAbs2().asDiagonal());
    map_.integrate(tick * kTick, step);
    decide(map_, tick * kTick, current_, place);
  }
  void correct(int steps) {
    OdometryCorrection correction;
    correction.from = kFirst * kTick;
    correction.to = (kFirst + steps) * kTick;
    correction.motion = Eigen::Translation3d(steps, 0.0, 0.0);
    correction.covariance = 1e-4 * TwistCovariance::Identity();
    map_.correct(correction);
  }
  static ExperienceMapParams params() {
    ExperienceMapParams p;
    p.exp_initial_em_deg = 0.0;
    return p;
  }

  ExperienceMap map_{params()};
  std::uint32_t current_ = 0;
};

TEST(Rejoin, ACorrectionOfTheFirstStepsOfAStretchDoesNotTieItToTheOneBefore) {
  const NewStretch stretch(false);
  for (int step = 0; step <= NewStretch::kUnknown + 4; ++step) EXPECT_LT(stretch.error(step), 1.0) << step;
}

TEST(Rejoin, NorDoesOneThatComesWhenTheStretchHasBeenJoined) {
  const NewStretch stretch(true);
  for (int step = 0; step <= NewStretch::kUnknown + 4; ++step) EXPECT_LT(stretch.error(step), 1.0) << step;
}

/// A chain of which some stretches are loose, and recalls; the last one disagrees with the chain.
PoseGraph looseGraph(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  PoseGraph graph(2.0);
  MapPose pose{};
  graph.addNode(pose);
  constexpr std::uint32_t kNodes = 60;
  bool loose = false;
  for (std::uint32_t node = 1; node < kNodes; ++node) {
    if (random() % 8 == 0) loose = !loose;
    Constraint step;
    step.from = node - 1;
    step.to = node;
    step.measured = {1.0, 0.0, 0.0, 0.2 * normal(random)};
    const double sigma = loose ? 5.0 + 3.0 * std::abs(normal(random)) : 0.05;
    weigh(step, Eigen::Vector4d(sigma, sigma, 0.1, loose ? 1.0 : 0.01).cwiseAbs2().asDiagonal());
    pose.x += std::cos(pose.yaw);
    pose.y += std::sin(pose.yaw);
    pose.yaw = wrapAngle(pose.yaw + step.measured.yaw);
    graph.addNode(pose);
    graph.addConstraint(step);
  }
  const auto recall = [&](std::uint32_t from, std::uint32_t to, double error) {
    const MapPose& there = graph.nodes()[from];
    const MapPose& here = graph.nodes()[to];
    const double dx = here.x - there.x + error * normal(random);
    const double dy = here.y - there.y + error * normal(random);
    Constraint constraint;
    constraint.from = from;
    constraint.to = to;
    constraint.recall = true;
    constraint.measured = {std::cos(there.yaw) * dx + std::sin(there.yaw) * dy,
                           std::cos(there.yaw) * dy - std::sin(there.yaw) * dx, 0.0,
                           wrapAngle(here.yaw - there.yaw)};
    weigh(constraint, Eigen::Vector4d(0.3, 0.3, 0.3, 0.1).cwiseAbs2().asDiagonal());
    graph.addConstraint(constraint);
  };
  for (int k = 0; k < 6; ++k) {
    const auto from = static_cast<std::uint32_t>(random() % 30);
    recall(from, from + 10 + static_cast<std::uint32_t>(random() % 15), random() % 2 == 0 ? 0.3 : 6.0);
  }
  recall(static_cast<std::uint32_t>(random() % 10), kNodes - 1, 8.0);
  return graph;
}

/// The nodes after rejoin(), by adding up the energy of the whole graph for each stretch and each way to cut it.
std::vector<MapPose> rejoinedByTrial(const PoseGraph& graph, const Constraint& recall) {
  const std::vector<MapPose>& nodes = graph.nodes();
  std::vector<MapPose> best = nodes;
  const double squared = PoseGraph::residual(recall, nodes[recall.from], nodes[recall.to]).squaredNorm();
  if (graph.weight(recall, squared) > 0.1) return best;  // the solver follows such a recall by itself
  double least = graph.energy(nodes) - 1.0;
  // Moved so that the recall fits exactly.
  const auto movedFrom = [&](std::uint32_t beyond) {
    const MapPose& there = nodes[recall.from];
    const MapPose& here = nodes[recall.to];
    const RelativePose& m = recall.measured;
    const double turn = wrapAngle(there.yaw + m.yaw - here.yaw);
    std::vector<MapPose> moved = nodes;
    for (std::size_t k = beyond; k < moved.size(); ++k) {
      const double dx = nodes[k].x - here.x;
      const double dy = nodes[k].y - here.y;
      moved[k].x = there.x + std::cos(there.yaw) * m.x - std::sin(there.yaw) * m.y + std::cos(turn) * dx -
                   std::sin(turn) * dy;
      moved[k].y = there.y + std::sin(there.yaw) * m.x + std::cos(there.yaw) * m.y + std::sin(turn) * dx +
                   std::cos(turn) * dy;
      moved[k].z += there.z + m.z - here.z;
      moved[k].yaw = wrapAngle(nodes[k].yaw + turn);
    }
    return moved;
  };
  const auto energyOf = [&](std::uint32_t node, const std::vector<MapPose>& at) {  // of the step to a node
    const Constraint& step = graph.constraints()[node - 1];
    return PoseGraph::residual(step, at[step.from], at[step.to]).squaredNorm();
  };
  for (std::uint32_t first = recall.from + 1; first <= recall.to;) {
    // The stretch of loose steps from `first` on.
    std::uint32_t end = first;
    std::uint32_t beyond = first;
    double shares = 0.0;
    for (; end <= recall.to && energyOf(end, movedFrom(end)) < 400.0; ++end) {
      shares += 1.0 / energyOf(end, movedFrom(end));
      if (energyOf(end, movedFrom(end)) < energyOf(beyond, movedFrom(beyond))) beyond = end;
    }
    if (end > first) {
      const std::vector<MapPose> moved = movedFrom(beyond);
      double energy = graph.energy(moved) + 1.0 / shares;
      for (std::uint32_t node = first; node < end; ++node) energy -= energyOf(node, moved);
      if (energy < least) {
        least = energy;
        best = moved;
      }
    }
    first = end + 1;
  }
  return best;
}

TEST(Rejoin, MovesTheNodesThatLowerTheEnergyMost) {
  int rejoined = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    PoseGraph graph = looseGraph(seed);
    const Constraint recall = graph.constraints().back();
    const std::vector<MapPose> expected = rejoinedByTrial(graph, recall);
    if (rejoin(graph, recall)) ++rejoined;
    for (std::size_t node = 0; node < expected.size(); ++node) {
      EXPECT_NEAR(graph.nodes()[node].x, expected[node].x, 1e-9) << "graph " << seed << ", node " << node;
      EXPECT_NEAR(graph.nodes()[node].y, expected[node].y, 1e-9) << "graph " << seed << ", node " << node;
    }
  }
  EXPECT_GT(rejoined, 100);
  EXPECT_LT(rejoined, 290);
}

}  // namespace
}  // namespace ratslam
