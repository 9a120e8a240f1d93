/// A round of places driven lap after lap: what is kept of recalls that are ignored, of the dark, of stops, and what is
/// known of the robot's place in a map that may not change.
#include <gtest/gtest.h>

#include <cmath>

#include "ratslam/experience_map/experience_map.h"

namespace ratslam {
namespace {

constexpr Stamp kTick = 100'000'000;

/// A robot that drives a round of `places` without error, 10 m from place to place.
class Round : public testing::Test {
 protected:
  static constexpr int kSteps = 10;  // from place to place

  void SetUp() override { map_.start(0); }

  OdometryStep step() const {
    OdometryStep step;
    step.forward = 1.0;
    step.rotation = 2.0 * kPi / (kPlaces * kSteps);
    return step;
  }

  void drive(int steps, bool bridged = false) {
    for (int k = 0; k < steps; ++k) {
      OdometryStep next = step();
      next.bridged = bridged;
      if (bridged) next.covariance = StepCovariance::Identity() * 1e-4;
      map_.integrate(stamp_ += kTick, next);
    }
  }

  void stand(int ticks) {
    for (int k = 0; k < ticks; ++k) map_.integrate(stamp_ += kTick, OdometryStep{});
  }

  void act(ActionKind kind, std::uint32_t place) {
    TopologicalAction action;
    action.stamp = stamp_;
    action.kind = kind;
    action.src_id = believed_;
    action.dest_id = believed_ = place;
    map_.apply(action);
  }

  void lap(bool first) {
    for (std::uint32_t place = 0; place < kPlaces; ++place) {
      drive(kSteps);
      act(first ? ActionKind::kCreateNode : ActionKind::kCreateEdge, place);
    }
  }

  double longestLink() const {
    double longest = 0.0;
    for (const Link& link : map_.graph().links()) {
      const MapPose& a = map_.graph().pose(link.from);
      const MapPose& b = map_.graph().pose(link.to);
      longest = std::max(longest, std::hypot(a.x - b.x, a.y - b.y));
    }
    return longest;
  }

  static constexpr std::uint32_t kPlaces = 40;
  ExperienceMap map_{ExperienceMapParams{}};
  Stamp stamp_ = 0;
  std::uint32_t believed_ = 0;
};

TEST_F(Round, ARecallThatIsIgnoredLeavesNoLinkBehind) {
  for (int k = 0; k < 4; ++k) lap(k == 0);
  for (std::uint32_t place = 0; place < 3; ++place) {
    drive(kSteps);
    act(ActionKind::kCreateEdge, place);
  }
  const std::size_t links = map_.graph().links().size();
  const MapPose before = map_.robotPose();
  act(ActionKind::kCreateEdge, 22);  // half a round away
  EXPECT_NEAR(map_.robotPose().x, before.x, 1e-9);
  EXPECT_NEAR(map_.robotPose().y, before.y, 1e-9);
  EXPECT_EQ(map_.currentExperience(), 2u);
  act(ActionKind::kCreateEdge, 2);  // the pose cells come back to where the map is still
  EXPECT_EQ(map_.graph().links().size(), links);
  act(ActionKind::kCreateEdge, 23);
  drive(kSteps);
  act(ActionKind::kCreateEdge, 3);
  EXPECT_EQ(map_.graph().links().size(), links);
  EXPECT_LT(longestLink(), 12.0);
}

TEST_F(Round, ASecondRecallInARowThatDisagreesIsUsed) {
  for (int k = 0; k < 4; ++k) lap(k == 0);
  drive(kSteps);
  act(ActionKind::kCreateEdge, 0);
  drive(kSteps);
  act(ActionKind::kCreateEdge, 20);
  drive(kSteps);
  act(ActionKind::kCreateEdge, 21);
  EXPECT_EQ(map_.currentExperience(), 21u);
}

TEST_F(Round, DarkStretchesOfKnownGroundDoNotAddUp) {
  for (int k = 0; k < 4; ++k) lap(k == 0);
  const std::size_t frames = map_.frames();
  for (int k = 0; k < 50; ++k) {
    for (std::uint32_t place = 0; place < kPlaces; ++place) {
      const bool dark = place >= 10 && place < 13;
      drive(kSteps, dark);
      if (!dark) act(ActionKind::kCreateEdge, place);
    }
  }
  EXPECT_LE(map_.frames(), frames + kPlaces);
}

TEST_F(Round, AStopOnTheWayDoesNotMakeTheWayLong) {
  drive(kSteps);
  act(ActionKind::kCreateNode, 0);
  drive(kSteps / 2);
  stand(10 * 3600 * 8);
  drive(kSteps / 2);
  act(ActionKind::kCreateNode, 1);
  EXPECT_NEAR(map_.graph().links().at(0).duration_s, 1.0, 1e-9);
}

TEST_F(Round, TheCovarianceOfARobotThatOnlyLocalisesIsThatOfThePlace) {
  std::vector<double> there;  // standard deviation of the pose when the place was made [m]
  const auto sigma = [this] { return std::sqrt(map_.robotCovariance()->topLeftCorner<2, 2>().trace()); };
  for (std::uint32_t place = 0; place < kPlaces / 2; ++place) {
    for (int k = 0; k < kSteps; ++k) {
      OdometryStep next = step();
      next.covariance = StepCovariance::Identity() * 1e-3;
      map_.integrate(stamp_ += kTick, next);
    }
    act(ActionKind::kCreateNode, place);
    there.push_back(sigma());
  }
  ASSERT_GT(there.back(), 30.0);
  map_.setLearning(false);
  for (const std::uint32_t place : {15u, 1u, 8u}) {
    act(ActionKind::kCreateEdge, place);
    const double recall = 20.0;  // twice the way between places, of which a recall names one
    EXPECT_GE(sigma(), there[place]) << "place " << place;
    EXPECT_LE(sigma(), std::hypot(there[place], recall)) << "place " << place;
  }
}

TEST_F(Round, TheCovarianceOfARobotThatOnlyLocalisesKnowsTheLoops) {
  for (int k = 0; k < 2; ++k) lap(k == 0);
  map_.settle();
  const Eigen::Matrix4d mapped = *map_.robotCovariance();
  for (std::uint32_t place = 0; place < kPlaces / 2; ++place) {
    drive(kSteps);
    act(ActionKind::kCreateEdge, place);
  }
  map_.settle();
  const double far_side = std::sqrt(map_.robotCovariance()->topLeftCorner<2, 2>().trace());
  map_.setLearning(false);
  act(ActionKind::kCreateEdge, kPlaces / 2 + 1);
  const double located = std::sqrt(map_.robotCovariance()->topLeftCorner<2, 2>().trace());
  EXPECT_GT(located, 0.5 * far_side);
  EXPECT_LT(located, 2.0 * far_side);
  EXPECT_LT(std::sqrt(mapped.topLeftCorner<2, 2>().trace()), far_side);
}

}  // namespace
}  // namespace ratslam
