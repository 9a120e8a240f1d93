/// What the map makes of what its odometry says of itself: weights, attitude, corrections, a metric unit.
#include <gtest/gtest.h>

#include "ratslam/experience_map/experience_map.h"

namespace ratslam {
namespace {

constexpr Stamp kTick = 100000000;

TopologicalAction action(ActionKind kind, std::uint32_t from, std::uint32_t to) {
  TopologicalAction action;
  action.kind = kind;
  action.src_id = from;
  action.dest_id = to;
  return action;
}

ExperienceMapParams params() {
  ExperienceMapParams p;
  p.exp_initial_em_deg = 0.0;
  p.exp_scale = true;
  p.exp_height = true;
  return p;
}

OdometryStep step(double forward, double rotation, double sigma_forward, double sigma_rotation) {
  OdometryStep step;
  step.dt = 0.1;
  step.forward = forward;
  step.rotation = rotation;
  step.covariance =
      StepCovariance(Eigen::Vector4d(sigma_forward, 0.1 * sigma_forward, 0.1 * sigma_forward, sigma_rotation)
                         .cwiseAbs2()
                         .asDiagonal());
  step.unit = UnitOfLength{0.0, 0.0};
  return step;
}

/// Twice round a square of 25 m a side, every place of the second lap recalled. On one side of the first lap
/// the odometry is wrong by `error` in length.
double cornerError(double said_there, double error) {
  ExperienceMap map(params());
  map.start(0);
  std::uint32_t current = 0;
  for (int k = 1; k <= 200; ++k) {
    const bool wrong = k > 30 && k <= 45;
    const double turn = k > 1 && k % 25 == 1 ? kPi / 2.0 : 0.0;
    map.integrate(k * kTick, step(wrong ? 1.0 + error : 1.0, turn, wrong ? said_there : 0.01, 1e-4));
    const bool recalled = k > 100;
    const auto to = static_cast<std::uint32_t>((k - 1) % 100);
    map.apply(action(recalled ? ActionKind::kCreateEdge : ActionKind::kCreateNode, current, to));
    current = to;
  }
  map.settle();
  // The place of step 25 is (25, 0), that of step 50 (25, 25): only the stretch that is wrong lies between.
  const MapPose& first = map.graph().pose(24);
  const MapPose& second = map.graph().pose(49);
  return std::abs(std::hypot(second.x - first.x, second.y - first.y) - 25.0);
}

TEST(OdometryThatSays, AnErrorIsMendedWhereTheOdometryAdmitsIt) {
  EXPECT_LT(cornerError(1.0, 0.5), 0.3);
  EXPECT_GT(cornerError(0.01, 0.5), 1.0) << "it is spread over all that is as uncertain";
}

TEST(OdometryThatSays, AMetricUnitStaysMetric) {
  ExperienceMap map(params());
  map.start(0);
  std::uint32_t current = 0;
  for (int k = 1; k <= 120; ++k) {
    map.integrate(k * kTick, step(1.0, 2.0 * kPi / 62.0, 0.02, 0.002));
    const auto to = static_cast<std::uint32_t>((k - 1) % 60);
    map.apply(action(k > 60 ? ActionKind::kCreateEdge : ActionKind::kCreateNode, current, to));
    current = to;
  }
  map.settle();
  for (const Experience& experience : map.graph().experiences()) {
    EXPECT_NEAR(experience.pose.log_scale, 0.0, 1e-4);
  }
}

TEST(OdometryThatSays, PosesKeepTheAttitudeOfTheOdometry) {
  ExperienceMap map(params());
  map.start(0);
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY()));
  OdometryStep tilted = step(1.0, 0.3, 0.01, 0.001);
  tilted.tilt = tilt;
  map.integrate(kTick, tilted);
  map.apply(action(ActionKind::kCreateNode, 0, 0));
  for (const auto& path : {map.finalTrajectory(), map.onlineTrajectory()}) {
    EXPECT_LT(path.back().tilt.angularDistance(tilt), 1e-12);
    const Eigen::Quaterniond expected = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()) * tilt;
    EXPECT_LT(path.back().attitude().angularDistance(expected), 1e-12);
  }
}

/// Twice round a square, every place of the second lap recalled. One side of the first lap was not measured,
/// and what the odometry says of it afterwards is wrong by 40 degrees, and sure of itself.
TEST(OdometryThatSays, AWrongCorrectionGivesWayToRecalls) {
  ExperienceMap map(params());
  map.start(0);
  std::uint32_t current = 0;
  for (int k = 1; k <= 200; ++k) {
    const bool bridged = k > 30 && k <= 45;
    const double turn = k > 1 && k % 25 == 1 ? kPi / 2.0 : 0.0;
    OdometryStep driven = step(1.0, turn, bridged ? 1.0 : 0.01, bridged ? 0.2 : 1e-4);
    driven.bridged = bridged;
    map.integrate(k * kTick, driven);
    const auto to = static_cast<std::uint32_t>((k - 1) % 100);
    map.apply(action(k > 100 ? ActionKind::kCreateEdge : ActionKind::kCreateNode, current, to));
    current = to;
    if (k != 46) continue;
    OdometryCorrection correction;
    correction.from = 30 * kTick;
    correction.to = 46 * kTick;
    const Eigen::AngleAxisd wrong(0.7, Eigen::Vector3d::UnitZ());
    correction.motion = wrong * Eigen::Translation3d(16.0, 0.0, 0.0);
    correction.covariance = 1e-4 * TwistCovariance::Identity();
    map.correct(correction);
  }
  map.settle();
  // The square's corners: places of steps 25, 50, 75 and 100.
  const Eigen::Vector2d corners[] = {{24.0, 0.0}, {24.0, 25.0}, {-1.0, 25.0}, {-1.0, 0.0}};
  const MapPose& start = map.graph().pose(0);
  for (int i = 0; i < 4; ++i) {
    const MapPose& place = map.graph().pose(static_cast<std::uint32_t>(25 * (i + 1) - 1));
    const Eigen::Vector2d at(place.x - start.x, place.y - start.y);
    EXPECT_LT((at - corners[i]).norm(), 1.0) << "corner " << i << " at " << at.transpose();
  }
}

/// A stretch that was predicted to be straight was a quarter turn after all.
TEST(OdometryThatSays, ACorrectionTakesThePlaceOfThePrediction) {
  for (const bool experiences_within : {true, false}) {
    ExperienceMap map(params());
    map.start(0);
    std::uint32_t made = 0;
    const auto drive = [&](int from, int to, bool bridged, bool create) {
      for (int k = from; k <= to; ++k) {
        OdometryStep driven = step(1.0, 0.0, bridged ? 1.0 : 0.01, bridged ? 0.3 : 1e-4);
        driven.bridged = bridged;
        map.integrate(k * kTick, driven);
        if (create) map.apply(action(ActionKind::kCreateNode, made == 0 ? 0 : made - 1, made));
        if (create) ++made;
      }
    };
    drive(1, 10, false, true);
    drive(11, 20, true, experiences_within);
    drive(21, 21, false, false);
    OdometryCorrection correction;
    correction.from = 10 * kTick;
    correction.to = 21 * kTick;
    correction.motion = Eigen::Translation3d(7.0, 7.0, 0.5) *
                        Eigen::Isometry3d(Eigen::AngleAxisd(kPi / 2.0, Eigen::Vector3d::UnitZ()));
    correction.covariance = 1e-4 * TwistCovariance::Identity();
    map.correct(correction);
    map.settle();
    const MapPose& robot = map.robotPose();
    EXPECT_NEAR(robot.x, 17.0, 0.05);
    EXPECT_NEAR(robot.y, 7.0, 0.05);
    EXPECT_NEAR(robot.z, 0.5, 0.05);
    EXPECT_NEAR(robot.yaw, kPi / 2.0, 0.01);
    // What lies between bends evenly: no step is longer than a few of the predicted ones.
    const auto path = map.finalTrajectory();
    for (std::size_t k = 11; k < path.size(); ++k) {
      EXPECT_LT(std::hypot(path[k].pose.x - path[k - 1].pose.x, path[k].pose.y - path[k - 1].pose.y), 2.5)
          << k;
    }
    // What was measured before stays.
    EXPECT_NEAR(path[9].pose.x, 9.0, 0.02);
    EXPECT_NEAR(path[9].pose.y, 0.0, 0.02);
  }
}

/// A long stretch whose source has kept only some of its samples: the others lie between them, on a smooth way.
TEST(OdometryThatSays, WhatACorrectionLeavesOutLiesBetweenWhatItSays) {
  ExperienceMap map(params());
  map.start(0);
  for (int k = 1; k <= 41; ++k) {
    OdometryStep driven = step(1.0, 0.0, 1.0, 0.3);
    driven.bridged = k > 1 && k < 41;
    map.integrate(k * kTick, driven);
    if (k == 1) map.apply(action(ActionKind::kCreateNode, 0, 0));
  }
  // It drove half a circle after all, to the left.
  const auto trueMotion = [](int k) {
    const double angle = kPi * (k - 1) / 40.0;
    return Eigen::Isometry3d(
        Eigen::Translation3d(10.0 * std::sin(angle), 10.0 - 10.0 * std::cos(angle), 0.0) *
        Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
  };
  OdometryCorrection correction;
  correction.from = kTick;
  correction.to = 41 * kTick;
  correction.motion = trueMotion(41);
  correction.covariance = 1e-4 * TwistCovariance::Identity();
  for (int k = 5; k < 41; k += 4) correction.way.push_back({k * kTick, trueMotion(k)});
  map.correct(correction);
  const auto path = map.finalTrajectory();
  for (std::size_t k = 1; k < path.size(); ++k) {
    const Eigen::Vector3d place = trueMotion(static_cast<int>(path[k].stamp / kTick)).translation();
    EXPECT_NEAR(path[k].pose.x - 1.0, place.x(), 0.15) << k;  // a metre before it
    EXPECT_NEAR(path[k].pose.y, place.y(), 0.15) << k;
  }
}

TEST(OdometryThatSays, ACorrectionOfUnknownTimesIsLeftOut) {
  ExperienceMap map(params());
  map.start(0);
  map.integrate(kTick, step(1.0, 0.0, 0.01, 1e-4));
  map.apply(action(ActionKind::kCreateNode, 0, 0));
  OdometryCorrection correction;
  correction.from = -5 * kTick;
  correction.to = kTick;
  map.correct(correction);
  EXPECT_NEAR(map.robotPose().x, 1.0, 1e-12);
  correction.motion.translation().x() = std::nan("");
  EXPECT_THROW(map.correct(correction), std::invalid_argument);
}

}  // namespace
}  // namespace ratslam
