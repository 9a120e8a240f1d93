#include "ratslam/experience_map/experience_map.h"

#include <gtest/gtest.h>

#include <limits>

#include "oracle/experience_map_drive.h"
#include "ratslam/common/pose2.h"
#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr Stamp kSecond = 1000000000;

OdometryStep motion(double forward, double rotation = 0.0, double up = 0.0) {
  OdometryStep step;
  step.forward = forward;
  step.rotation = rotation;
  step.up = up;
  return step;
}

TopologicalAction action(ActionKind kind, std::uint32_t src, std::uint32_t dest, double relative_rad = 0.0) {
  TopologicalAction result;
  result.kind = kind;
  result.src_id = src;
  result.dest_id = dest;
  result.relative_rad = relative_rad;
  return result;
}

/// A map whose facing at the start is 0, with experiences a metre apart along x.
class SmallMap : public testing::TestWithParam<const char*> {
 protected:
  static ExperienceMapParams params() {
    ExperienceMapParams params;
    params.exp_solver = GetParam();
    params.exp_initial_em_deg = 0.0;
    return params;
  }

  SmallMap() : map(params()) {
    map.start(0);
    for (std::uint32_t k = 0; k < 4; ++k) {
      map.integrate((k + 1) * kSecond, motion(1.0));
      map.apply(action(ActionKind::kCreateNode, k == 0 ? 0 : k - 1, k));
    }
  }

  ExperienceMap map;
};

TEST_P(SmallMap, LinksWhatTheRobotDrove) {
  ASSERT_EQ(map.graph().experiences().size(), 4U);
  ASSERT_EQ(map.graph().links().size(), 3U);
  for (std::uint32_t k = 0; k < 3; ++k) {
    const Link& link = map.graph().links()[k];
    EXPECT_EQ(link.from, k);
    EXPECT_EQ(link.to, k + 1);
    EXPECT_DOUBLE_EQ(link.distance, 1.0);
    EXPECT_DOUBLE_EQ(link.duration_s, 1.0);
    EXPECT_FALSE(link.recall);
  }
  EXPECT_NEAR(map.robotPose().x, 4.0, 1e-12);
  EXPECT_EQ(map.currentExperience(), 3U);
}

/// Known ground that may not change: the recall places the robot as far ahead of the experience as the views tell.
TEST_P(SmallMap, ARecallPlacesTheRobotAheadOfTheExperienceAndChangesNothing) {
  map.setLearning(false);
  RecallGeometry geometry;
  geometry.ahead = 0.3;
  map.integrate(5 * kSecond, motion(0.5));
  map.apply(action(ActionKind::kCreateEdge, 3, 1), &geometry);
  EXPECT_NEAR(map.robotPose().x, 2.3, 1e-9);
  EXPECT_NEAR(map.robotPose().y, 0.0, 1e-9);
  EXPECT_EQ(map.graph().links().size(), 3U);
}

/// An experience that was made ahead of its view, which was known already.
TEST(ExperienceMap, ARecallFromWhereTheExperienceWasMadePlacesTheRobotAtIt) {
  ExperienceMap map(ExperienceMapParams{});
  map.start(0);
  RecallGeometry geometry;
  map.integrate(1 * kSecond, motion(1.0));
  map.apply(action(ActionKind::kCreateNode, 0, 0));
  map.integrate(2 * kSecond, motion(1.0));
  geometry.ahead = 0.4;
  map.apply(action(ActionKind::kCreateNode, 0, 1), &geometry);
  map.setLearning(false);
  map.integrate(3 * kSecond, motion(0.5));
  map.apply(action(ActionKind::kCreateEdge, 1, 0));
  map.apply(action(ActionKind::kCreateEdge, 0, 1), &geometry);
  EXPECT_NEAR(map.robotPose().x, map.graph().pose(1).x, 1e-9);
}

TEST_P(SmallMap, ASettledCopyLeavesTheMapAsItWas) {
  State before;
  State after;
  map.save(before);
  const auto copy = map.settled();
  map.save(after);
  EXPECT_TRUE(before == after);
  EXPECT_EQ(copy->graph().experiences().size(), map.graph().experiences().size());
}

TEST_P(SmallMap, RejectsActionsThatDoNotFitAndStaysAsItWas) {
  const std::uint64_t revision = map.revision();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  RecallGeometry bad_geometry;
  bad_geometry.sigma_rotation = 0.0;
  EXPECT_THROW(map.apply(action(ActionKind::kCreateNode, 3, 5)), std::invalid_argument);
  EXPECT_THROW(map.apply(action(ActionKind::kCreateNode, 3, 2)), std::invalid_argument);
  EXPECT_THROW(map.apply(action(ActionKind::kCreateNode, 9, 4)), std::invalid_argument);
  EXPECT_THROW(map.apply(action(ActionKind::kCreateEdge, 3, 4)), std::invalid_argument);
  EXPECT_THROW(map.apply(action(ActionKind::kCreateEdge, 3, 3)), std::invalid_argument);
  EXPECT_THROW(map.apply(action(ActionKind::kCreateEdge, 17, 0)), std::invalid_argument);
  EXPECT_THROW(map.apply(action(ActionKind::kSetNode, 3, 4)), std::invalid_argument);
  EXPECT_THROW(map.apply(action(ActionKind::kCreateEdge, 3, 0, nan)), std::invalid_argument);
  EXPECT_THROW(map.apply(action(ActionKind::kCreateEdge, 3, 0), &bad_geometry), std::invalid_argument);
  EXPECT_EQ(map.revision(), revision);
  EXPECT_EQ(map.currentExperience(), 3U);
  EXPECT_NO_THROW(map.apply(action(ActionKind::kCreateEdge, 3, 0)));
}

TEST_P(SmallMap, RejectsOdometryThatDoesNotFitAndStaysAsItWas) {
  const MapPose before = map.robotPose();
  EXPECT_THROW(map.integrate(3 * kSecond, motion(1.0)), std::invalid_argument);
  EXPECT_THROW(map.integrate(5 * kSecond, motion(std::numeric_limits<double>::infinity())),
               std::invalid_argument);
  EXPECT_THROW(map.integrate(5 * kSecond, motion(0.0, std::numeric_limits<double>::quiet_NaN())),
               std::invalid_argument);
  EXPECT_EQ(map.robotPose().x, before.x);
  EXPECT_EQ(map.onlineTrajectory().size(), 5U);
}

/// A camera that is covered all night: what is predicted meanwhile must not fill the memory.
TEST_P(SmallMap, DoesNotGrowWithAStretchThatIsOnlyPredicted) {
  const auto size = [this] {
    State state;
    map.save(state);
    return state.child("solver").toBytes().size();
  };
  const std::size_t before = size();
  OdometryStep step = motion(0.01);
  step.bridged = true;
  step.covariance = Eigen::Matrix4d(1e-4 * Eigen::Matrix4d::Identity());
  for (int k = 0; k < 100000; ++k) map.integrate((10 + k) * kSecond, step);
  EXPECT_LT(size(), before + 300 * 400) << "at most 300 frames of some hundred bytes";
}

TEST_P(SmallMap, LinksTwoExperiencesOnce) {
  map.apply(action(ActionKind::kCreateEdge, 3, 1));
  EXPECT_EQ(map.graph().links().size(), 4U);
  EXPECT_TRUE(map.graph().links().back().recall);
  map.integrate(5 * kSecond, motion(1.0));
  map.apply(action(ActionKind::kCreateEdge, 1, 3));
  EXPECT_EQ(map.graph().links().size(), 4U);
  EXPECT_EQ(map.currentExperience(), 3U);
}

TEST_P(SmallMap, SetNodeMakesNoLink) {
  map.apply(action(ActionKind::kSetNode, 3, 1));
  EXPECT_EQ(map.graph().links().size(), 3U);
  EXPECT_EQ(map.currentExperience(), 1U);
}

TEST_P(SmallMap, SetNodeTellsNothingThatOdometryHasNotTold) {
  const std::size_t frames = map.frames();
  map.integrate(5 * kSecond, motion(-1.5));  // to between the second and the third
  map.apply(action(ActionKind::kSetNode, 3, 2));
  map.settle();
  EXPECT_EQ(map.currentExperience(), 2U);
  EXPECT_EQ(map.frames(), frames);
  // Relaxation, which knows no other place than an experience, puts the robot there.
  EXPECT_NEAR(map.robotPose().x, params().relaxes() ? 3.0 : 2.5, 1e-9);
}

TEST_P(SmallMap, LinksNothingAcrossAJumpOfTheClock) {
  const std::size_t links = map.graph().links().size();
  map.integrate(5 * kSecond, motion(0.5));
  map.start(2 * kSecond);
  map.integrate(4 * kSecond, motion(0.5));
  map.apply(action(ActionKind::kCreateNode, 3, 4));
  EXPECT_EQ(map.graph().links().size(), links) << "nobody measured the way to the first place after the jump";
  map.integrate(5 * kSecond, motion(1.0));
  map.apply(action(ActionKind::kCreateNode, 4, 5));
  EXPECT_DOUBLE_EQ(map.graph().links().back().duration_s, 1.0);
  EXPECT_DOUBLE_EQ(map.graph().links().back().distance, 1.0);
}

TEST_P(SmallMap, ARecallAfterAJumpOfTheClockMakesNoLinkAndLeavesTheMapAlone) {
  const std::size_t links = map.graph().links().size();
  const MapPose before = map.graph().pose(0);
  map.start(0);
  map.integrate(kSecond, motion(0.0));
  map.apply(action(ActionKind::kCreateEdge, 3, 0));
  map.settle();
  EXPECT_EQ(map.graph().links().size(), links);
  EXPECT_EQ(map.currentExperience(), 0U);
  EXPECT_NEAR(map.graph().pose(0).x, before.x, 1e-3);
  EXPECT_NEAR(map.graph().pose(0).y, before.y, 1e-3);
  EXPECT_NEAR(map.robotPose().x, before.x, 1e-2);
  EXPECT_NEAR(map.robotPose().y, before.y, 1e-2);
}

TEST_P(SmallMap, KeepsOnePoseAStampTheOneAfterTheAction) {
  const std::size_t samples = map.onlineTrajectory().size();
  map.integrate(5 * kSecond, motion(1.0));
  map.apply(action(ActionKind::kCreateEdge, 3, 0));
  ASSERT_EQ(map.onlineTrajectory().size(), samples + 1);
  ASSERT_EQ(map.finalTrajectory().size(), samples + 1);
  EXPECT_EQ(map.onlineTrajectory().back().stamp, 5 * kSecond);
  EXPECT_EQ(map.onlineTrajectory().back().pose.x, map.robotPose().x);
  EXPECT_NEAR(map.finalTrajectory().back().pose.x, map.robotPose().x, 1e-12);
}

TEST_P(SmallMap, TiesTheWayToTheFirstExperienceToIt) {
  // The first pose was 1 m before experience 0 and still is, whatever became of the map.
  map.apply(action(ActionKind::kCreateEdge, 3, 0));
  map.settle();
  const RelativePose start = between(map.graph().pose(0), map.finalTrajectory().front().pose);
  EXPECT_NEAR(start.x, -1.0, 1e-12);
  EXPECT_NEAR(start.y, 0.0, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Solvers, SmallMap, testing::Values("graph", "relaxation"));

TEST(ExperienceMap, NeedsAClock) {
  ExperienceMap map{ExperienceMapParams{}};
  EXPECT_THROW(map.integrate(0, motion(1.0)), std::invalid_argument);
  EXPECT_THROW(map.apply(action(ActionKind::kCreateNode, 0, 0)), std::invalid_argument);
}

TEST(ExperienceMap, WithoutLoopsPosesAreDeadReckoningToTheLastBit) {
  CityDrive city;
  city.experiences = 500;
  city.recall_share = 0.0;
  city.length_noise = 0.05;
  city.yaw_noise = 0.01;
  const auto drive = simulate(city);
  ExperienceMapParams params;
  params.exp_scale = true;
  params.exp_height = true;
  ExperienceMap map(params);
  run(map, drive);
  map.settle();
  Pose2 reckoned{0.0, 0.0, degreesToRadians(90.0)};
  for (std::size_t k = 1; k < drive.size(); ++k) {
    const OdometryStep& step = drive[k].motion;
    reckoned = compose(reckoned, Pose2{step.forward * std::cos(wrapAngle(step.rotation)),
                                       step.forward * std::sin(wrapAngle(step.rotation)), step.rotation});
    const MapPose& pose = map.graph().pose(static_cast<std::uint32_t>(k - 1));
    ASSERT_EQ(pose.x, reckoned.x);
    ASSERT_EQ(pose.y, reckoned.y);
    ASSERT_EQ(pose.yaw, reckoned.th);
    ASSERT_EQ(pose.z, 0.0);
    ASSERT_EQ(pose.log_scale, 0.0);
  }
}

TEST(ExperienceMap, IsAFunctionOfItsInput) {
  CityDrive city;
  city.experiences = 800;
  city.blocks = 2;
  city.recall_share = 0.3;
  city.length_noise = 0.02;
  city.yaw_noise = 0.002;
  const auto drive = simulate(city);
  ExperienceMapParams params;
  params.exp_scale = true;
  ExperienceMap first(params);
  ExperienceMap second(params);
  run(first, drive);
  run(second, drive);
  const auto same = [](const std::vector<StampedPose>& a, const std::vector<StampedPose>& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const StampedPose& p, const StampedPose& q) {
      return p.stamp == q.stamp && p.pose.x == q.pose.x && p.pose.y == q.pose.y && p.pose.yaw == q.pose.yaw &&
             p.pose.log_scale == q.pose.log_scale;
    });
  };
  EXPECT_TRUE(same(first.onlineTrajectory(), second.onlineTrajectory()));
  EXPECT_TRUE(same(first.finalTrajectory(), second.finalTrajectory()));
}

/// The odometry's way of stating the same drive must not matter: in several steps between two images, or in
/// one.
TEST(ExperienceMap, IntegratesBetweenImages) {
  ExperienceMap coarse{ExperienceMapParams{}};
  ExperienceMap fine{ExperienceMapParams{}};
  coarse.start(0);
  fine.start(0);
  for (std::uint32_t k = 0; k < 5; ++k) {
    coarse.integrate((k + 1) * kSecond, motion(2.0, 0.3));
    fine.integrate(k * kSecond + kSecond / 3, motion(0.0, 0.3));
    fine.integrate((k + 1) * kSecond, motion(2.0));
    coarse.apply(action(ActionKind::kCreateNode, k == 0 ? 0 : k - 1, k));
    fine.apply(action(ActionKind::kCreateNode, k == 0 ? 0 : k - 1, k));
  }
  EXPECT_NEAR(coarse.robotPose().x, fine.robotPose().x, 1e-12);
  EXPECT_NEAR(coarse.robotPose().y, fine.robotPose().y, 1e-12);
}

TEST(ExperienceMap, CarriesHeightAndMendsIt) {
  constexpr int kLap = 200;
  ExperienceMapParams params;
  params.exp_height = true;
  ExperienceMap map(params);
  map.start(0);
  for (int k = 1; k <= 2 * kLap; ++k) {
    // Uphill and down again; the odometry adds 2 cm a step.
    map.integrate(k * kSecond, motion(1.0, 2.0 * kPi / kLap, 0.1 * std::cos(2.0 * kPi * k / kLap) + 0.02));
    const auto id = static_cast<std::uint32_t>((k - 1) % kLap);
    map.apply(action(k <= kLap ? ActionKind::kCreateNode : ActionKind::kCreateEdge, 0, id));
  }
  map.settle();
  const auto z = [&](std::uint32_t id) { return map.graph().pose(id).z; };
  EXPECT_NEAR(z(kLap / 4) - z(3 * kLap / 4), 2.0 * 0.1 * kLap / (2.0 * kPi), 1.0);
  EXPECT_NEAR(z(kLap - 1), z(0), 0.25 * 0.02 * kLap);
  EXPECT_NEAR(map.robotPose().z, z(kLap - 1), 1.5);
}

TEST(ExperienceMap, AFlatMapIgnoresHeight) {
  ExperienceMap map{ExperienceMapParams{}};
  map.start(0);
  map.integrate(kSecond, motion(1.0, 0.0, 5.0));
  map.apply(action(ActionKind::kCreateNode, 0, 0));
  map.integrate(2 * kSecond, motion(1.0, 0.0, 5.0));
  EXPECT_EQ(map.robotPose().z, 0.0);
}

/// relative_rad is the heading now minus that of the recalled experience; the link's facing leads back to the
/// latter.
TEST(ExperienceMap, TakesTheRelativeHeadingOfARecall) {
  ExperienceMapParams params;
  params.exp_recall_facing_sigma = 0.001;
  params.exp_rotation_sigma = 0.1;
  ExperienceMap map(params);
  map.start(0);
  map.integrate(1 * kSecond, motion(1.0));
  map.apply(action(ActionKind::kCreateNode, 0, 0));
  // A small circle back to the place, facing about 0.35 rad to the left of how it was.
  for (int k = 0; k < 20; ++k) {
    map.integrate((k + 2) * kSecond, motion(1.0, 2.0 * kPi / 20));
    if (k == 9) map.apply(action(ActionKind::kCreateNode, 0, 1));
    if (k == 14) map.apply(action(ActionKind::kCreateNode, 1, 2));
  }
  map.integrate(30 * kSecond, motion(0.0, 0.35));
  map.apply(action(ActionKind::kCreateEdge, 2, 0, 0.3));
  map.settle();
  EXPECT_NEAR(wrapAngle(map.robotPose().yaw - map.graph().pose(0).yaw), 0.3, 0.001);
  EXPECT_NEAR(map.graph().links().back().facing_rad, kPi / 2.0 + 0.35 - 0.3, 1e-9);
}

}  // namespace
}  // namespace ratslam
