/// A stretch that nobody measured, from what is known of its ends and of the frames in between.
#include "ratslam/odometry/orb/motion_bridge.h"

#include <gtest/gtest.h>

#include <random>

#include "ratslam/common/angles.h"
#include "ratslam/common/state.h"
#include "ratslam/odometry/orb/map_initialiser.h"
#include "street_scene.h"

namespace ratslam {
namespace {

constexpr double kSpeed = 8.0;  // [m/s]
constexpr double kGap = 3.0;    // [s]
constexpr double kTurn = 0.05;  // a frame, after the gap [rad]
constexpr double kFrame = 0.1;  // [s]

Vector6 twistOf(double turn_rate) {
  Vector6 twist = Vector6::Zero();
  twist(2) = kSpeed;
  twist(4) = turn_rate;
  return twist;
}

MotionHistory straightBefore() {
  MotionHistory history(1.0);
  for (int i = -20; i <= 0; ++i) history.add(stampFromSeconds(kFrame * i), twistOf(0.0));
  return history;
}

TEST(MotionHistory, ATurnThatWandersMovesTheEndOfTheWayAside) {
  constexpr double kLength = 20.0;
  constexpr double kDeviation = 0.3;
  constexpr int kSteps = 50;
  constexpr int kTrials = 4000;
  std::mt19937 random(3);
  std::normal_distribution<double> turns(0.0, kDeviation / std::sqrt(kSteps));
  double aside_squared = 0.0;
  double together = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    double turned = 0.0;
    double aside = 0.0;
    for (int step = 0; step < kSteps; ++step) {
      turned += turns(random);
      aside += kLength / kSteps * std::sin(turned);  // to the right, about the axis that points down
    }
    aside_squared += aside * aside / kTrials;
    together += aside * turned / kTrials;
  }
  const Matrix6 covariance = MotionHistory::spread({0.0, 0.0, kLength}, 0.0, kDeviation * kDeviation);
  EXPECT_NEAR(covariance(0, 4), together, 0.1 * together);
  EXPECT_EQ(covariance(4, 0), covariance(0, 4));
  EXPECT_NEAR(covariance(0, 0), aside_squared, 0.2 * aside_squared);
  EXPECT_EQ(covariance.llt().info(), Eigen::Success);
}

class GapBeforeATurn : public testing::Test {
 protected:
  /// Nothing for kGap, then frames that turn evenly, each connected to the one before.
  GapBeforeATurn() {
    for (int i = 0; i <= kFramesAfter; ++i) {
      MotionBridge::Step step;
      step.stamp = stampFromSeconds(kGap + kFrame * i);
      step.pose.translation.z() = kSpeed * (kGap + kFrame * i);
      if (i > 0) {
        step.seen = UncertainMotion{};
        step.seen->motion.rotation = expRotation({0.0, kTurn, 0.0});
        step.seen->motion.translation = Eigen::Vector3d::UnitZ();
        step.seen->covariance = 1e-6 * Matrix6::Identity();
      }
      last_ = std::make_shared<Frame>();
      last_->stamp = step.stamp;
      bridge_.add(step, last_);
    }
  }
  UncertainMotion motionToLast() {
    WorkerPool workers(1);
    return bridge_.motionTo(test::smallCamera(), *last_, twistOf(kTurn / kFrame), history_, workers);
  }
  static constexpr int kFramesAfter = 12;
  MotionHistory history_ = straightBefore();
  MotionBridge bridge_{0, RigidTransform{}, nullptr};
  std::shared_ptr<Frame> last_;
};

TEST_F(GapBeforeATurn, TurnRatesAtBothEndsFillIt) {
  const UncertainMotion motion = motionToLast();
  const double in_gap = 0.5 * (0.0 + kTurn / kFrame) * kGap;
  EXPECT_NEAR(logRotation(motion.motion.rotation).y(), in_gap + kFramesAfter * kTurn, 1e-6);
  // What the seen frames turned is known: all doubt is that of the gap, known at both ends.
  const double variance =
      MotionHistory::turnVariance(Eigen::Vector3d::Zero(), {0.0, kTurn / kFrame, 0.0}, kGap);
  EXPECT_NEAR(motion.covariance(4, 4), variance, 0.01 * variance);
  EXPECT_LT(motion.motion.translation.norm(), kSpeed * (kGap + kFramesAfter * kFrame));
  EXPECT_GT(motion.motion.translation.x(), 1.0) << "it turned right";
}

TEST_F(GapBeforeATurn, AStraightRoadIsKnownBetterThanATurn) {
  const auto degrees = [](double before, double after, double duration) {
    return radiansToDegrees(
        std::sqrt(MotionHistory::turnVariance({0.0, before, 0.0}, {0.0, after, 0.0}, duration)));
  };
  EXPECT_NEAR(degrees(0.0, 0.0, 3.0), 3.0, 1.0);
  EXPECT_GT(degrees(0.0, 0.4, 3.0), 25.0);
  EXPECT_EQ(degrees(0.0, 0.4, 3.0), degrees(-0.4, 0.0, 3.0));
  EXPECT_GT(degrees(0.0, 0.0, 6.0), 2.0 * degrees(0.0, 0.0, 3.0));
}

TEST_F(GapBeforeATurn, PitchAndRollDoNotGoOnWhereNobodyLooks) {
  MotionHistory bump(1.0);
  Vector6 twist = twistOf(0.0);
  twist(3) = twist(5) = 0.05;
  for (int i = -20; i <= 0; ++i) bump.add(stampFromSeconds(kFrame * i), twist);
  history_ = bump;
  const Eigen::Vector3d turn = logRotation(motionToLast().motion.rotation);
  EXPECT_NEAR(turn.x(), 0.0, 1e-9);
  EXPECT_NEAR(turn.z(), 0.0, 1e-9);
  EXPECT_EQ(logRotation(bump.predict(0.0, 3.0).motion.rotation).norm(), 0.0);
}

TEST_F(GapBeforeATurn, WayLaidAnewTurnsWhereTheFramesTurned) {
  const UncertainMotion motion = motionToLast();
  const auto way = bridge_.layOut({{last_->stamp, motion.motion}}, twistOf(0.0), twistOf(kTurn / kFrame));
  ASSERT_EQ(way.size(), static_cast<std::size_t>(kFramesAfter));
  for (std::size_t i = 1; i < way.size(); ++i) {
    const Eigen::Quaterniond step = way[i - 1].pose.rotation.conjugate() * way[i].pose.rotation;
    EXPECT_NEAR(logRotation(step).y(), kTurn, 1e-6) << i;
  }
}

TEST_F(GapBeforeATurn, TurnBetweenFramesIsKnownOnlyWhereAllAreConnected) {
  MotionBridge::Step next;
  next.stamp = stampFromSeconds(kGap + kFrame * (kFramesAfter + 1));
  next.seen = UncertainMotion{};
  next.seen->motion.rotation = expRotation({0.0, kTurn, 0.0});
  const auto turn = bridge_.turnSince(stampFromSeconds(kGap), next);
  ASSERT_TRUE(turn);
  EXPECT_NEAR(logRotation(turn->rotation).y(), (kFramesAfter + 1) * kTurn, 1e-9);
  EXPECT_FALSE(bridge_.turnSince(0, next)) << "the gap lies between";
  next.seen.reset();
  EXPECT_FALSE(bridge_.turnSince(stampFromSeconds(kGap), next));
}

/// Images that show something now and then, for hours, and no map: 10 a second.
/// A robot that is parked before a camera that shows nothing.
TEST(MotionHistory, PredictsNoEndlessDrive) {
  MotionHistory history(0.0);
  Vector6 twist = Vector6::Zero();
  twist(2) = 2.0;
  for (int k = 0; k < 20; ++k) history.add(k * 100'000'000LL, twist);
  EXPECT_GT(history.predict(0.0, 3.0).motion.translation.norm(), 5.0);
  EXPECT_EQ(history.predict(100.0, 3600.0).motion.translation.norm(), 0.0);
  EXPECT_GT(history.predict(100.0, 3600.0).covariance(2, 2), 1.0);
}

TEST(LongBridge, TakesABoundedAmountOfMemoryAndStillSpansTheWholeTime) {
  const auto bridgeOf = [](int samples, bool connected) {
    MotionBridge bridge(0, RigidTransform{}, nullptr);
    for (int i = 1; i <= samples; ++i) {
      MotionBridge::Step step;
      step.stamp = stampFromSeconds(kFrame * i);
      step.pose.translation.z() = 0.001 * i;
      if (connected) {
        step.seen = UncertainMotion{};
        step.seen->motion.translation = Eigen::Vector3d::UnitZ();
        step.seen->covariance = 1e-9 * Matrix6::Identity();
      }
      auto frame = std::make_shared<Frame>();
      frame->stamp = step.stamp;
      bridge.add(step, frame);
    }
    return bridge;
  };
  for (const bool connected : {false, true}) {
    std::size_t bytes[2] = {};
    for (const int hours : {1, 4}) {
      const int samples = hours * 36000;
      const MotionBridge bridge = bridgeOf(samples, connected);
      const Stamp end = stampFromSeconds(kFrame * samples);
      Vector6 slow = Vector6::Zero();
      slow(2) = 0.01;
      RigidTransform there;
      there.translation.z() = 0.001 * samples;
      const auto way = bridge.layOut({{end, there}}, slow, slow);
      ASSERT_FALSE(way.empty());
      EXPECT_LT(way.size(), 5000U);
      for (std::size_t i = 0; i < way.size(); ++i) {
        ASSERT_LT(i > 0 ? way[i - 1].stamp : 0, way[i].stamp);
        ASSERT_NEAR(way[i].pose.translation.z(), 0.01 * toSeconds(way[i].stamp), 0.1) << i;
      }
      EXPECT_GT(way.back().stamp, end - stampFromSeconds(1.0));
      EXPECT_LE(bridge.frames().size(), 41U);
      Frame frame;
      frame.stamp = end;
      WorkerPool workers(1);
      MotionHistory history(1.0);
      for (int i = -20; i <= 0; ++i) history.add(stampFromSeconds(kFrame * i), slow);
      const UncertainMotion motion = bridge.motionTo(test::smallCamera(), frame, slow, history, workers);
      EXPECT_NEAR(motion.motion.translation.z(), 0.001 * samples, 0.01 * 0.001 * samples);
      EXPECT_TRUE(motion.covariance.allFinite());
      State state;
      FramesToSave none;
      bridge.save(state, none);
      bytes[hours == 1 ? 0 : 1] = state.toBytes().size();
    }
    EXPECT_LT(bytes[1], bytes[0] * 3 / 2);
  }
}

/// Frames along a street, as a small camera sees them.
std::shared_ptr<Frame> streetFrame(double along) {
  static const test::StreetScene scene;
  const CameraModel camera = test::smallCamera();
  ExtractorParams params;
  params.features = 1000;
  WorkerPool workers(1);
  return std::make_shared<Frame>(makeFrame(stampFromSeconds(along),
                                           scene.render(camera, test::cameraAt(0.0, along)), camera,
                                           FeatureExtractor(params), params, workers));
}

TEST(MapInitialiser, AMapThatTurnsOtherwiseThanTheFramesIsNone) {
  for (const double false_turn : {0.0, 0.03, -0.03}) {
    MapInitialiser initialiser(test::smallCamera(), TwoViewParams{40, 1.0, 1.0}, 10);
    initialiser.add(streetFrame(0.0));
    const UncertainTurn turn{expRotation({0.0, false_turn, 0.0}), Eigen::Matrix3d::Zero()};
    EXPECT_EQ(initialiser.add(streetFrame(1.2), turn).has_value(), false_turn == 0.0) << false_turn;
  }
}

/// Each reference loses its near points before the far ones have moved enough: without a second way no map would begin on
/// such a street.
TEST(MapInitialiser, AfterALostReferenceManyPointsMakeUpForLittleParallax) {
  constexpr double kNeverReached = 5.0;  // [deg]
  MapInitialiser initialiser(test::smallCamera(), TwoViewParams{40, kNeverReached, 1.0}, 10);
  int frames = 0;
  while (!initialiser.add(streetFrame(0.8 * frames))) {
    ASSERT_LT(++frames, 60);
    if (frames > 1 && !initialiser.progress().lost_reference) {
      EXPECT_EQ(initialiser.reference()->stamp, 0) << "the first reference is kept as long as it has matches";
    }
  }
  EXPECT_TRUE(initialiser.progress().lost_reference);
  EXPECT_GT(initialiser.reference()->stamp, 0);
  initialiser.reset();
  EXPECT_FALSE(initialiser.progress().lost_reference);
}

}  // namespace
}  // namespace ratslam
