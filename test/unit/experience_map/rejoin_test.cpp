/// A way that nobody measured, with a corner in it: what lies beyond is joined by the recalls that come later.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "ratslam/experience_map/experience_map.h"

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

}  // namespace
}  // namespace ratslam
