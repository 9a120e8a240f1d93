/// What a map that carries scale promises: recalls alone reveal how the odometry's scale drifts.
#include <gtest/gtest.h>

#include <functional>

#include "oracle/experience_map_drive.h"

namespace ratslam {
namespace {

/// Laps of a ring that is 1 m wide a step, with a given log-scale of the odometry at each step. Every place
/// of the later laps is recalled.
std::vector<DriveStep> ringDrive(int lap, int laps, const std::function<double(int)>& log_scale) {
  std::vector<DriveStep> drive(static_cast<std::size_t>(lap * laps) + 1);
  std::uint32_t current = 0;
  for (int k = 1; k <= lap * laps; ++k) {
    DriveStep& step = drive[static_cast<std::size_t>(k)];
    step.end = static_cast<Stamp>(k) * 100000000;
    step.motion.forward = std::exp(log_scale(k));
    step.motion.rotation = 2.0 * kPi / lap;
    step.action.kind = k <= lap ? ActionKind::kCreateNode : ActionKind::kCreateEdge;
    step.action.src_id = current;
    current = static_cast<std::uint32_t>((k - 1) % lap);
    step.action.dest_id = current;
  }
  return drive;
}

ExperienceMapParams scaleParams() {
  ExperienceMapParams params;
  params.exp_scale = true;
  params.exp_recall_sigma = 1.0;
  return params;
}

double distance(const MapPose& a, const MapPose& b) { return std::hypot(a.x - b.x, a.y - b.y); }

/// Greatest departure of the experiences from their ring, as a share of its radius.
double ringError(const ExperienceMap& map, int lap) {
  double mean_x = 0.0;
  double mean_y = 0.0;
  for (const Experience& experience : map.graph().experiences()) {
    mean_x += experience.pose.x / lap;
    mean_y += experience.pose.y / lap;
  }
  double mean_radius = 0.0;
  for (const Experience& experience : map.graph().experiences()) {
    mean_radius += std::hypot(experience.pose.x - mean_x, experience.pose.y - mean_y) / lap;
  }
  double worst = 0.0;
  for (const Experience& experience : map.graph().experiences()) {
    const double radius = std::hypot(experience.pose.x - mean_x, experience.pose.y - mean_y);
    worst = std::max(worst, std::abs(radius - mean_radius) / mean_radius);
  }
  return worst;
}

TEST(ScaleMap, RestoresALoopWhoseScaleRamps) {
  constexpr int kLap = 300;
  const auto drive = ringDrive(kLap, 2, [](int k) { return -0.0004 * k; });
  ExperienceMapParams params = scaleParams();
  ExperienceMap with_scale(params);
  run(with_scale, drive);
  with_scale.settle();
  params.exp_scale = false;
  ExperienceMap without(params);
  run(without, drive);
  without.settle();
  EXPECT_LT(ringError(with_scale, kLap), 0.01);
  EXPECT_GT(ringError(without, kLap), 0.03);
}

/// The less recalls and prior are allowed to disagree with the exact measurements, the nearer the map is to
/// the truth.
TEST(ScaleMap, ErrorVanishesWithTheNoise) {
  constexpr int kLap = 200;
  const auto drive = ringDrive(kLap, 3, [](int k) { return -0.0003 * k; });
  double last = 1.0;
  for (const double place : {1.0, 0.1, 0.01}) {
    ExperienceMapParams params = scaleParams();
    params.exp_recall_sigma = place;
    params.exp_recall_facing_sigma = 0.1 * place;
    ExperienceMap map(params);
    run(map, drive);
    map.settle();
    const double error = ringError(map, kLap);
    EXPECT_LT(error, last);
    last = error;
  }
  EXPECT_LT(last, 1e-4);
}

/// Out along a street, back to its start by a block, and along it again at another scale.
TEST(ScaleMap, AStreetDrivenTwiceHasOneLength) {
  constexpr int kStreet = 200;
  constexpr int kSide = 60;
  std::vector<DriveStep> drive(1);
  std::uint32_t current = 0;
  const auto go = [&](int steps, double turn, double scale, std::uint32_t first_recall, bool recall) {
    for (int k = 0; k < steps; ++k) {
      DriveStep step;
      step.end = static_cast<Stamp>(drive.size()) * 100000000;
      step.motion.forward = scale;
      step.motion.rotation = k == 0 ? turn : 0.0;
      step.action.kind = recall ? ActionKind::kCreateEdge : ActionKind::kCreateNode;
      step.action.src_id = current;
      current = recall ? first_recall + static_cast<std::uint32_t>(k)
                       : static_cast<std::uint32_t>(drive.size() - 1);
      step.action.dest_id = current;
      drive.push_back(step);
    }
  };
  const double quarter = kPi / 2.0;
  go(kStreet, 0.0, 1.0, 0, false);
  go(kSide, quarter, 0.96, 0, false);
  go(kStreet, quarter, 0.92, 0, false);
  go(kSide, quarter, 0.88, 0, false);
  go(kStreet, quarter, 0.84, 0, true);

  ExperienceMap map(scaleParams());
  run(map, drive);
  map.settle();
  const auto path = map.finalTrajectory();
  const double first = distance(path[1].pose, path[kStreet].pose);
  const double second = distance(path[path.size() - kStreet].pose, path.back().pose);
  EXPECT_NEAR(second / first, 1.0, 0.01);
  EXPECT_NEAR(map.robotPose().scale() / map.graph().pose(kStreet / 2).scale(), 1.0 / 0.84, 0.03);
}

TEST(ScaleMap, StaysMetricWhereTheOdometryIs) {
  CityDrive city;
  city.experiences = 1500;
  city.blocks = 2;
  city.recall_share = 0.3;
  city.length_noise = 0.01;
  city.yaw_noise = 0.0005;
  ExperienceMap map(scaleParams());
  run(map, simulate(city));
  map.settle();
  double largest = 0.0;
  for (const Experience& experience : map.graph().experiences()) {
    largest = std::max(largest, std::abs(experience.pose.log_scale));
  }
  EXPECT_GT(largest, 0.0);
  EXPECT_LT(largest, 0.02);
}

TEST(ScaleMap, OneWrongRecallAmongTwentyMovesTheMapLittle) {
  constexpr int kLap = 300;
  std::vector<DriveStep> right = ringDrive(kLap, 2, [](int k) { return -0.0002 * k; });
  // Of the second lap every 15th place is recalled, the others are new.
  std::uint32_t created = kLap;
  std::uint32_t current = kLap - 1;
  for (std::size_t k = kLap + 1; k < right.size(); ++k) {
    TopologicalAction& action = right[k].action;
    action.src_id = current;
    if ((k - kLap) % 15 != 0) {
      action.kind = ActionKind::kCreateNode;
      action.dest_id = created++;
    }
    current = action.dest_id;
  }
  std::vector<DriveStep> wrong = right;
  constexpr std::size_t kWrong = kLap + 150;
  ASSERT_EQ(wrong[kWrong].action.kind, ActionKind::kCreateEdge);
  wrong[kWrong].action.dest_id = 20;
  wrong[kWrong + 1].action.src_id = 20;

  for (const bool scale : {false, true}) {
    ExperienceMapParams params;
    params.exp_scale = scale;
    ExperienceMap good(params);
    ExperienceMap fooled(params);
    run(good, right);
    run(fooled, wrong);
    good.settle();
    fooled.settle();
    double moved = 0.0;
    const auto good_path = good.finalTrajectory();
    const auto fooled_path = fooled.finalTrajectory();
    for (std::size_t k = 0; k < good_path.size(); ++k) {
      moved = std::max(moved, distance(good_path[k].pose, fooled_path[k].pose));
    }
    EXPECT_LT(moved, 1.0) << "scale " << scale;
  }
}

/// A new experience is as large as the one it was linked from, and so is the way between experiences.
TEST(ScaleMap, DeadReckonsAtTheScaleOfThePlace) {
  constexpr int kLap = 300;
  ExperienceMap map(scaleParams());
  const auto drive = ringDrive(kLap, 2, [](int k) { return -0.0005 * k; });
  run(map, drive);
  map.settle();
  const double scale = map.robotPose().scale();
  EXPECT_NEAR(scale, std::exp(0.0005 * 2 * kLap), 0.05);

  const MapPose before = map.robotPose();
  OdometryStep step;
  step.forward = 3.0;
  Stamp stamp = drive.back().end + 100000000;
  map.integrate(stamp, step);
  EXPECT_NEAR(distance(before, map.robotPose()), 3.0 * scale, 1e-9);
  TopologicalAction create;
  create.stamp = stamp;
  create.kind = ActionKind::kCreateNode;
  create.src_id = *map.currentExperience();
  create.dest_id = kLap;
  map.apply(create);
  EXPECT_EQ(map.graph().pose(kLap).log_scale, before.log_scale);
}

/// Forward along a road and back over the same frames in reverse order: the odometry runs backwards.
TEST(ScaleMap, ThereAndBackKeepsScaleAndSign) {
  constexpr int kRoad = 250;
  std::vector<DriveStep> drive(2 * kRoad);
  for (int k = 1; k < 2 * kRoad; ++k) {
    DriveStep& step = drive[static_cast<std::size_t>(k)];
    const bool back = k > kRoad;
    step.end = static_cast<Stamp>(k) * 100000000;
    step.motion.forward = (back ? -1.0 : 1.0) * std::exp(-0.0002 * k);
    step.motion.rotation = (back ? -1.0 : 1.0) * 0.004;
    step.action.kind = back ? ActionKind::kCreateEdge : ActionKind::kCreateNode;
    step.action.dest_id = static_cast<std::uint32_t>(back ? 2 * kRoad - k - 1 : k - 1);
    step.action.src_id = k == 1 ? 0 : drive[static_cast<std::size_t>(k) - 1].action.dest_id;
  }
  ExperienceMap map(scaleParams());
  run(map, drive);
  map.settle();
  const MapPose first = map.graph().pose(0);
  EXPECT_LT(distance(map.robotPose(), first), 1.5);
  EXPECT_NEAR(map.robotPose().scale(), std::exp(0.0002 * 2 * kRoad), 0.03);
  // The end of the road lies ahead of its start, not behind it.
  const RelativePose end = between(first, map.graph().pose(kRoad / 4));
  EXPECT_GT(end.x, 0.0);
}

}  // namespace
}  // namespace ratslam
