#include "ratslam/system/map_stage.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr Stamp kSecond = 1'000'000'000;

TopologicalAction action(Stamp stamp, ActionKind kind, std::uint32_t src, std::uint32_t dest) {
  TopologicalAction result;
  result.stamp = stamp;
  result.kind = kind;
  result.src_id = src;
  result.dest_id = dest;
  return result;
}

TEST(MapStage, ADecisionThatIsRefusedTakesNoneOfTheOthersAlong) {
  MapStage stage(ExperienceMapParams{}, GeometrySource::kNone);
  stage.addDecision(action(1 * kSecond, ActionKind::kCreateNode, 0, 0));
  stage.addDecision(action(2 * kSecond, ActionKind::kCreateNode, 0, 1));
  stage.addDecision(action(3 * kSecond, ActionKind::kCreateNode, 1, 77));
  stage.addDecision(action(4 * kSecond, ActionKind::kCreateNode, 1, 2));
  for (int second = 0; second <= 5; ++second) {
    OdometrySample sample;
    sample.stamp = second * kSecond;
    sample.speed = 1.0;
    stage.addOdometry(sample);
  }
  EXPECT_EQ(stage.drain(), (std::vector<Stamp>{1 * kSecond, 2 * kSecond, 4 * kSecond}));
  const std::vector<std::string> refusals = stage.takeRefusals();
  ASSERT_EQ(refusals.size(), 1U);
  EXPECT_NE(refusals.front().find("77"), std::string::npos) << refusals.front();
  EXPECT_TRUE(stage.takeRefusals().empty());
  EXPECT_EQ(stage.map().graph().experiences().size(), 3U);
}

OdometrySample sampleAt(Stamp stamp, double speed) {
  OdometrySample sample;
  sample.stamp = stamp;
  sample.speed = speed;
  return sample;
}

RecallGeometry geometryAt(Stamp stamp) {
  RecallGeometry geometry;
  geometry.stamp = stamp;
  return geometry;
}

std::size_t bytesOf(const MapStage& stage) {
  State state;
  stage.save(state);
  return state.toBytes().size();
}

/// Number of geometries that wait for their decisions.
std::size_t waitingGeometry(const MapStage& stage) {
  State state;
  stage.save(state);
  return state.get<std::vector<RecallGeometry>>("geometry").size();
}

TEST(MapStage, ANumberBeyondAllSensePutsNoMemoryAside) {
  MapStage stage(ExperienceMapParams{}, GeometrySource::kNone);
  stage.addOdometry(sampleAt(0, 1.0));
  TopologicalAction absurd = action(kSecond, ActionKind::kCreateNode, 0, 99'999'999);
  absurd.session = {1, 0};
  stage.addDecision(absurd);
  stage.addOdometry(sampleAt(kSecond, 1.0));
  EXPECT_TRUE(stage.drain().empty());
  EXPECT_EQ(stage.takeRefusals().size(), 1U);
  EXPECT_LT(bytesOf(stage), 1'000'000U);
}

TEST(MapStage, GeometryThatNoDecisionAsksForIsBoundedAndTheMapGoesOn) {
  constexpr int kSilent = 50'000;  // images while the pose cells are dead
  MapStage stage(ExperienceMapParams{}, GeometrySource::kImages);
  stage.addOdometry(sampleAt(0, 1.0));
  for (int second = 1; second <= kSilent; ++second) {
    stage.addOdometry(sampleAt(second * kSecond, 1.0));
    stage.addGeometry(geometryAt(second * kSecond));
  }
  EXPECT_LE(waitingGeometry(stage), 20'000U);
  EXPECT_EQ(stage.forgottenGeometry() + waitingGeometry(stage), static_cast<std::size_t>(kSilent));
  EXPECT_LT(bytesOf(stage), 20'000'000U);
  // The pose cells are back: what they still had counts as not measured, what is new waits for its geometry.
  stage.addDecision(action(10 * kSecond, ActionKind::kCreateNode, 0, 0));
  stage.addDecision(action((kSilent - 1) * kSecond, ActionKind::kCreateNode, 0, 1));
  stage.addDecision(action((kSilent + 1) * kSecond, ActionKind::kCreateNode, 1, 2));
  stage.addOdometry(sampleAt((kSilent + 1) * kSecond, 1.0));
  EXPECT_EQ(stage.drain(), (std::vector<Stamp>{10 * kSecond, (kSilent - 1) * kSecond}));
  stage.addGeometry(geometryAt((kSilent + 1) * kSecond));
  EXPECT_EQ(stage.drain(), (std::vector<Stamp>{(kSilent + 1) * kSecond}));
  EXPECT_EQ(waitingGeometry(stage), 0U);
}

/// The map was not there when the geometry of the first image was told.
TEST(MapStage, GeometryThatALaterOneHasOvertakenIsNotWaitedFor) {
  for (const GeometrySource source : {GeometrySource::kLikeness, GeometrySource::kImages}) {
    MapStage stage(ExperienceMapParams{}, source);
    for (int second = 0; second <= 3; ++second) stage.addOdometry(sampleAt(second * kSecond, 1.0));
    stage.addDecision(action(1 * kSecond, ActionKind::kCreateNode, 0, 0));
    stage.addDecision(action(2 * kSecond, ActionKind::kCreateNode, 0, 1));
    EXPECT_TRUE(stage.drain().empty());
    stage.addGeometry(geometryAt(2 * kSecond));
    EXPECT_EQ(stage.drain(), (std::vector<Stamp>{1 * kSecond, 2 * kSecond}));
  }
}

/// A looped bag whose decisions of the first lap wait for the geometry of their recalls when the second begins.
TEST(MapStage, DecisionsThatWaitWhenTimeGoesBackGetTheirOwnMotion) {
  MapStage stage(ExperienceMapParams{}, GeometrySource::kImages);
  const auto addSamples = [&] {
    for (int second = 0; second <= 3; ++second) stage.addOdometry(sampleAt(second * kSecond, 1.0));
  };
  addSamples();
  for (int second = 1; second <= 3; ++second) {
    const auto number = static_cast<std::uint32_t>(second - 1);
    stage.addDecision(
        action(second * kSecond, ActionKind::kCreateNode, number == 0 ? 0 : number - 1, number));
  }
  EXPECT_TRUE(stage.drain().empty());
  addSamples();
  EXPECT_FALSE(stage.addDecision(action(1 * kSecond, ActionKind::kCreateNode, 2, 3)));
  for (int second = 1; second <= 3; ++second) stage.addGeometry(geometryAt(second * kSecond));
  EXPECT_EQ(stage.drain(), (std::vector<Stamp>{1 * kSecond, 2 * kSecond, 3 * kSecond}));
  stage.addGeometry(geometryAt(1 * kSecond));
  EXPECT_EQ(stage.drain(), (std::vector<Stamp>{1 * kSecond}));
  const auto& experiences = stage.map().graph().experiences();
  ASSERT_EQ(experiences.size(), 4U);
  EXPECT_NEAR(std::hypot(experiences[2].pose.x - experiences[0].pose.x,
                         experiences[2].pose.y - experiences[0].pose.y),
              2.0, 1e-6);
}

RecallGeometry measuredAt(Stamp stamp, std::uint32_t view, double distance_ratio) {
  RecallGeometry geometry = geometryAt(stamp);
  geometry.view_id = view;
  geometry.inliers = 50;
  geometry.relative_rad = 0.5;
  geometry.distance_ratio = distance_ratio;
  geometry.sigma_ratio = geometry.sigma_rotation = geometry.sigma_direction = 0.01;
  return geometry;
}

/// Two laps of a looped bag with the same stamps. The second recalls a view of itself, whose distance is that of the way
/// between its template and the companion. @param ahead  whether the second lap's geometry comes before the first one's
/// last decision
StampedPose poseAfterTwoLaps(bool ahead) {
  MapStage stage(ExperienceMapParams{}, GeometrySource::kImages);
  const auto decide = [&stage](int second, ActionKind kind, std::uint32_t src, std::uint32_t dest) {
    stage.addDecision(action(second * kSecond, kind, src, dest));
    stage.drain();
  };
  const auto measure = [&stage](int second, std::uint32_t view) {
    RecallGeometry geometry = geometryAt(second * kSecond);
    geometry.view_id = view;
    stage.addGeometry(geometry);
    stage.drain();
  };
  const auto measureSecondLap = [&] {
    for (int second = 1; second <= 3; ++second) measure(second, static_cast<std::uint32_t>(second + 3));
    RecallGeometry recall = measuredAt(4 * kSecond, 5, 0.5);
    recall.template_stamp = 2 * kSecond;
    recall.companion_stamp = 1 * kSecond;
    stage.addGeometry(recall);
    stage.drain();
  };
  const auto drive = [&](int second) {
    stage.addOdometry(sampleAt(second * kSecond, 1.0));
    stage.drain();
  };
  drive(0);
  for (int second = 1; second <= 4; ++second) {
    measure(second, static_cast<std::uint32_t>(second - 1));
    if (second < 4) drive(second);
    if (ahead && second == 4) measureSecondLap();
    const auto number = static_cast<std::uint32_t>(second - 1);
    decide(second, ActionKind::kCreateNode, number == 0 ? 0 : number - 1, number);
  }
  drive(4);
  for (int second = 0; second <= 3; ++second) drive(second);
  if (!ahead) measureSecondLap();
  for (int second = 1; second <= 3; ++second) {
    const auto number = static_cast<std::uint32_t>(second + 3);
    decide(second, ActionKind::kCreateNode, number - 1, number);
  }
  drive(4);
  decide(4, ActionKind::kCreateEdge, 6, 5);
  EXPECT_EQ(stage.waitingDecisions(), 0U) << "ahead " << ahead;
  return stage.latestPose();
}

TEST(MapStage, GeometryOfAnotherTimeMayComeBeforeTheOldTimesLastDecision) {
  const StampedPose in_order = poseAfterTwoLaps(false);
  const StampedPose ahead = poseAfterTwoLaps(true);
  EXPECT_EQ(in_order.stamp, 4 * kSecond);
  EXPECT_EQ(in_order.stamp, ahead.stamp);
  EXPECT_EQ(in_order.pose.x, ahead.pose.x);
  EXPECT_EQ(in_order.pose.y, ahead.pose.y);
  EXPECT_EQ(in_order.pose.yaw, ahead.pose.yaw);
}

/// Whoever asks after each sample gets what somebody gets who asks once, also across decisions and a lap that begins anew.
TEST(MapStage, TheLatestPoseDoesNotDependOnHowOftenItIsAskedFor) {
  const auto poses = [](bool each_time) {
    MapStage stage(ExperienceMapParams{}, GeometrySource::kNone);
    std::vector<StampedPose> asked;
    for (int lap = 0; lap < 2; ++lap) {
      for (int k = 0; k <= 100; ++k) {
        OdometrySample sample = sampleAt(k * kSecond / 10, 1.0 + 0.01 * k);
        sample.yaw_rate = 0.3;
        stage.addOdometry(sample);
        if (k % 40 == 7) {
          const std::uint32_t next =
              stage.map().currentExperience() ? *stage.map().currentExperience() + 1 : 0;
          stage.addDecision(
              action(sample.stamp - kSecond / 20, ActionKind::kCreateNode, next == 0 ? 0 : next - 1, next));
          stage.drain();
        }
        if (each_time) stage.latestPose();
        if (k % 25 == 24) asked.push_back(stage.latestPose());
      }
    }
    return asked;
  };
  const std::vector<StampedPose> often = poses(true);
  const std::vector<StampedPose> rarely = poses(false);
  ASSERT_EQ(often.size(), 8U);
  for (std::size_t k = 0; k < often.size(); ++k) {
    EXPECT_EQ(often[k].stamp, rarely[k].stamp) << k;
    EXPECT_EQ(often[k].pose.x, rarely[k].pose.x) << k;
    EXPECT_EQ(often[k].pose.y, rarely[k].pose.y) << k;
    EXPECT_EQ(often[k].pose.yaw, rarely[k].pose.yaw) << k;
  }
}

TEST(MapStage, AFastOdometryDoesNotMakeItLarger) {
  const auto bytesAfterTenMinutes = [](int samples_a_second) {
    ExperienceMapParams params;
    params.exp_trajectory_poses = 1000;
    MapStage stage(params, GeometrySource::kImages);
    for (int k = 0; k <= 600 * samples_a_second; ++k) {
      const Stamp stamp = k * kSecond / samples_a_second;
      stage.addOdometry(sampleAt(stamp, 0.0));
      if (k % samples_a_second != 0) continue;
      stage.addDecision(action(stamp + 1, k == 0 ? ActionKind::kCreateNode : ActionKind::kNone, 0, 0));
      stage.addGeometry(geometryAt(stamp + 1));
      stage.drain();
    }
    EXPECT_LE(stage.waitingDecisions(), 1U);
    return bytesOf(stage);
  };
  EXPECT_LT(bytesAfterTenMinutes(100), bytesAfterTenMinutes(2) + 200'000) << "a second of samples waits";
}

}  // namespace
}  // namespace ratslam
