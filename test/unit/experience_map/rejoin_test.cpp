/// A way that nobody measured, with a corner in it: what lies beyond is joined by the recalls that come later.
#include <gtest/gtest.h>

#include "ratslam/experience_map/experience_map.h"

namespace ratslam {
namespace {

constexpr Stamp kTick = 100000000;
constexpr int kSide = 25;
constexpr int kLap = 4 * kSide;
constexpr int kSilence = 40;  // steps, with a corner among them

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
    TopologicalAction action;
    action.stamp = k * kTick;
    action.kind =
        place < map_.graph().experiences().size() ? ActionKind::kCreateEdge : ActionKind::kCreateNode;
    action.src_id = current_;
    action.dest_id = place;
    map_.apply(action);
    current_ = place;
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
  SilentLap lap(0.05);  // whoever says so is believed
  const int k = kLap + kSilence + 11;
  lap.drive(k, static_cast<std::uint32_t>((k - 1) % kLap));
  EXPECT_GT(lap.distanceTo(static_cast<std::uint32_t>((k - 1) % kLap)), 20.0);
}

}  // namespace
}  // namespace ratslam
