#include "ratslam/odometry/odometry_timeline.h"

#include <gtest/gtest.h>

#include <limits>

#include "ratslam/common/pose2.h"
#include "ratslam/experience_map/map_pose.h"
#include "ratslam/odometry/uncertainty.h"

namespace ratslam {
namespace {

constexpr Stamp kSecond = 1000000000;

OdometrySample twist(double t, double speed, double yaw_rate) {
  OdometrySample sample;
  sample.stamp = stampFromSeconds(t);
  sample.speed = speed;
  sample.yaw_rate = yaw_rate;
  return sample;
}

OdometrySample posed(double t, double x, double y, double z, double yaw) {
  OdometrySample sample = twist(t, 0.0, 0.0);
  sample.pose = Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ());
  return sample;
}

/// Where steps lead, from a pose: the heading turns first, then the robot moves along it.
Pose2 follow(Pose2 pose, const std::vector<TimedStep>& steps) {
  for (const TimedStep& timed : steps) {
    pose = compose(pose, {0.0, 0.0, timed.step.rotation});
    pose = compose(pose, {timed.step.forward, timed.step.left, 0.0});
  }
  return pose;
}

TEST(OdometryTimeline, FirstSampleOnlySetsTheClock) {
  OdometryTimeline timeline(false);
  EXPECT_FALSE(timeline.reached(0));
  EXPECT_EQ(timeline.push(twist(1.0, 7.0, 1.0)), SampleVerdict::kAccepted);
  EXPECT_TRUE(timeline.reached(kSecond));
  EXPECT_TRUE(timeline.advanceTo(kSecond).empty());
}

TEST(OdometryTimeline, DividesASampleAtAnImagesStamp) {
  OdometryTimeline timeline(false);
  timeline.push(twist(0.0, 0.0, 0.0));
  timeline.push(twist(1.0, 2.0, 0.4));
  const auto first = timeline.advanceTo(kSecond / 4);
  const auto second = timeline.advanceTo(kSecond);
  ASSERT_EQ(first.size(), 1U);
  ASSERT_EQ(second.size(), 1U);
  EXPECT_DOUBLE_EQ(first[0].step.forward, 0.5);
  EXPECT_DOUBLE_EQ(first[0].step.rotation, 0.1);
  EXPECT_DOUBLE_EQ(second[0].step.forward, 1.5);
  EXPECT_DOUBLE_EQ(second[0].step.dt, 0.75);
  EXPECT_EQ(second[0].end, kSecond);
}

TEST(OdometryTimeline, PosesLeadWhereTheyLeadHoweverTheyAreDivided) {
  for (const double part : {0.0, 0.2, 0.7, 1.0}) {
    OdometryTimeline timeline(true);
    timeline.push(posed(0.0, 1.0, 2.0, 0.0, 0.5));
    timeline.push(posed(1.0, 3.0, 1.5, 0.3, 1.1));
    auto steps = timeline.advanceTo(stampFromSeconds(part));
    for (const TimedStep& rest : timeline.advanceTo(kSecond)) steps.push_back(rest);
    const Pose2 end = follow({1.0, 2.0, 0.5}, steps);
    EXPECT_NEAR(end.x, 3.0, 1e-12);
    EXPECT_NEAR(end.y, 1.5, 1e-12);
    EXPECT_NEAR(end.th, 1.1, 1e-12);
    double up = 0.0;
    for (const TimedStep& timed : steps) up += timed.step.up;
    EXPECT_NEAR(up, 0.3, 1e-12);
  }
}

TEST(OdometryTimeline, BadSamplesChangeNothing) {
  OdometryTimeline timeline(false);
  timeline.push(twist(0.0, 0.0, 0.0));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(timeline.push(twist(1.0, nan, 0.0)), SampleVerdict::kImpossible);
  EXPECT_EQ(timeline.push(twist(1.0, 0.0, infinity)), SampleVerdict::kImpossible);
  EXPECT_EQ(timeline.push(twist(1.0, 1e308, 0.0)),
            SampleVerdict::kImpossible);  // finite, but not once added up
  EXPECT_EQ(timeline.push(twist(1.0, 0.0, -1e7)), SampleVerdict::kImpossible);
  EXPECT_EQ(timeline.push(twist(0.0, 1.0, 1.0)), SampleVerdict::kRepeatedStamp);
  EXPECT_EQ(timeline.push(twist(-1.0, 1.0, 1.0)), SampleVerdict::kTimeWentBack);
  timeline.push(twist(2.0, 3.0, 0.0));
  const auto steps = timeline.advanceTo(2 * kSecond);
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_DOUBLE_EQ(steps[0].step.forward, 6.0);
}

/// All motion up to a stamp as one.
Motion sumOf(const std::vector<TimedStep>& steps) {
  Motion motion;
  for (const TimedStep& timed : steps) motion.add(timed.step);
  return motion;
}

TEST(OdometryTimeline, SilenceIsNotDrivenThroughAtTheNextSpeed) {
  OdometryTimeline timeline(false);
  for (int i = 0; i <= 10; ++i) timeline.push(twist(0.1 * i, 2.0, 0.3));
  timeline.advanceTo(kSecond);
  timeline.push(twist(21.0, 2.0, 0.3));
  const auto halves = {timeline.advanceTo(11 * kSecond), timeline.advanceTo(21 * kSecond)};
  double variance = 0.0;
  for (const auto& steps : halves) {
    ASSERT_EQ(steps.size(), 1U);
    EXPECT_EQ(steps[0].step.forward, 0.0);
    EXPECT_EQ(steps[0].step.rotation, 0.0);
    EXPECT_TRUE(steps[0].step.bridged);
    ASSERT_TRUE(steps[0].step.covariance);
    variance += (*steps[0].step.covariance)(0, 0);
  }
  EXPECT_NEAR(std::sqrt(variance), 40.0, 1e-9) << "20 s at the greatest speed so far";
  EXPECT_EQ(timeline.unmeasured(), 1U);
}

TEST(OdometryTimeline, SilenceIsMeasuredWhereTheSourceSaysHowWell) {
  OdometryTimeline timeline(false);
  timeline.push(twist(0.0, 1.0, 0.0));
  OdometrySample sample = twist(5.0, 1.0, 0.0);
  sample.covariance = 0.04 * TwistCovariance::Identity();
  sample.unit = UnitOfLength{};
  timeline.push(sample);
  const auto steps = timeline.advanceTo(5 * kSecond);
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_EQ(steps[0].step.forward, 5.0);
  EXPECT_NEAR((*steps[0].step.covariance)(0, 0), 0.04 * 25.0, 1e-12);
}

TEST(OdometryTimeline, PosesTellWhereASilenceHasLed) {
  OdometryTimeline timeline(false);
  timeline.push(posed(0.0, 0.0, 0.0, 0.0, 0.0));
  for (int i = 1; i <= 10; ++i) {
    OdometrySample sample = posed(0.1 * i, 0.2 * i, 0.0, 0.0, 0.0);
    sample.speed = 2.0;
    timeline.push(sample);
  }
  timeline.advanceTo(kSecond);
  OdometrySample after = posed(6.0, 9.0, 3.0, 0.0, 0.5);
  after.speed = 2.0;
  timeline.push(after);
  const Motion across = sumOf(timeline.advanceTo(6 * kSecond));
  EXPECT_NEAR(across.pose.x, 7.0, 1e-9);
  EXPECT_NEAR(across.pose.y, 3.0, 1e-9);
  EXPECT_GT(across.error.covariance(0, 0), 50.0);
}

/// A source that starts anew at its origin, with and without a change of epoch to tell it.
TEST(OdometryTimeline, APoseThatIsResetIsNotDriven) {
  for (const bool says_so : {true, false}) {
    for (const bool use_pose : {true, false}) {
      OdometryTimeline timeline(use_pose);
      for (int i = 0; i <= 20; ++i) {
        OdometrySample sample = posed(0.1 * i, 1.0 * i, 0.0, 0.0, 0.2);
        sample.speed = 10.0;
        timeline.push(sample);
      }
      timeline.advanceTo(2 * kSecond);
      OdometrySample reset = posed(2.1, 0.0, 0.0, 0.0, 0.0);
      reset.speed = 10.0;
      reset.epoch = says_so ? 1 : 0;
      timeline.push(reset);
      OdometrySample next = posed(2.2, 1.0, 0.0, 0.0, 0.0);
      next.speed = 10.0;
      next.epoch = reset.epoch;
      timeline.push(next);
      const auto steps = timeline.advanceTo(stampFromSeconds(2.2));
      ASSERT_EQ(steps.size(), 2U);
      EXPECT_NEAR(steps[0].step.forward, 1.0, 1e-9);
      EXPECT_NEAR(steps[0].step.rotation, 0.0, 1e-9);
      EXPECT_TRUE(steps[0].step.new_unit);
      EXPECT_TRUE(steps[0].step.covariance);
      EXPECT_NEAR(steps[1].step.forward, 1.0, 1e-9);
      EXPECT_FALSE(steps[1].step.new_unit);
      EXPECT_EQ(timeline.unmeasured(), 1U);
    }
  }
}

TEST(OdometryTimeline, APoseWithoutATwistIsFollowed) {
  OdometryTimeline timeline(false);
  for (int i = 0; i <= 60; ++i) timeline.push(posed(0.1 * i, 0.5 * i, 0.0, 0.0, 0.05 * i));
  const Motion motion = sumOf(timeline.advanceTo(6 * kSecond));
  EXPECT_NEAR(motion.pose.x, 30.0, 1e-9);
  EXPECT_NEAR(motion.pose.yaw, 3.0, 1e-9);
  timeline.push(posed(6.1, 0.0, 0.0, 0.0, 3.0));
  const Motion reset = sumOf(timeline.advanceTo(stampFromSeconds(6.1)));
  EXPECT_EQ(reset.pose.x, 0.0) << "back at its origin";
}

TEST(OdometryTimeline, ALateSampleIsLeftOutAndAnAbsurdCovarianceNotUsed) {
  OdometryTimeline timeline(false);
  timeline.push(twist(0.0, 1.0, 0.0));
  timeline.push(twist(1.0, 1.0, 0.0));
  EXPECT_EQ(timeline.push(twist(0.75, 9.0, 0.0)), SampleVerdict::kLate);
  TwistCovariance negative = TwistCovariance::Identity();
  negative(0, 0) = -1.0;
  TwistCovariance skewed = TwistCovariance::Identity();
  skewed(0, 5) = 0.5;
  TwistCovariance beyond = TwistCovariance::Identity();  // no two errors are tied closer than being the same
  beyond(0, 5) = beyond(5, 0) = 2.0;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  double t = 1.0;
  for (const TwistCovariance& absurd :
       {negative, skewed, beyond, TwistCovariance(1e12 * TwistCovariance::Identity()),
        TwistCovariance(nan * TwistCovariance::Identity())}) {
    OdometrySample sample = twist(t += 0.5, 1.0, 0.0);
    sample.covariance = absurd;
    EXPECT_EQ(timeline.push(sample), SampleVerdict::kAccepted);
    EXPECT_NE(whyAbsurd(absurd), "");
  }
  for (const TimedStep& timed : timeline.advanceTo(4 * kSecond)) EXPECT_FALSE(timed.step.covariance);
}

// A visual odometry bridges a gap, then finds its place anew: the pose is put right by 15 m, told as a correction later.
TEST(OdometryTimeline, ASourceThatSaysItsUnitPutsItsPoseRightWithoutANewUnit) {
  const auto seen = [](double t, double x) {
    OdometrySample sample = posed(t, x, 0.0, 0.0, 0.0);
    sample.speed = 4.0;
    sample.covariance = 0.01 * TwistCovariance::Identity();
    sample.unit = UnitOfLength{};
    return sample;
  };
  for (const bool says_its_unit : {true, false}) {
    OdometryTimeline timeline(true);
    std::vector<OdometrySample> samples{seen(0.0, 0.0), seen(0.1, 0.4), seen(0.2, -14.2), seen(0.3, -13.8)};
    for (OdometrySample& sample : samples) {
      if (!says_its_unit) sample.unit.reset();
      timeline.push(sample);
    }
    const auto steps = timeline.advanceTo(kSecond * 3 / 10);
    ASSERT_EQ(steps.size(), 3U);
    EXPECT_NEAR(steps[1].step.forward, 0.4, 1e-9);
    EXPECT_EQ(steps[1].step.new_unit, !says_its_unit);
    EXPECT_EQ(timeline.unmeasured(), says_its_unit ? 0U : 1U);
    ASSERT_TRUE(steps[1].step.covariance);
    EXPECT_EQ((*steps[1].step.covariance)(0, 0) < 0.001, says_its_unit);
  }
}

TEST(OdometryTimeline, AttitudeIsThatOfThePose) {
  OdometryTimeline timeline(true);
  const auto tilted = [](double t, double pitch) {
    OdometrySample sample = twist(t, 1.0, 0.0);
    sample.pose = Eigen::Translation3d(t, 0.0, 0.0) *
                  Eigen::Isometry3d(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()));
    return sample;
  };
  timeline.push(tilted(0.0, 0.1));
  timeline.push(tilted(1.0, 0.3));
  const auto steps = {timeline.advanceTo(kSecond / 2), timeline.advanceTo(kSecond)};
  double expected = 0.2;
  for (const auto& part : steps) {
    EXPECT_LT(part[0].step.tilt.angularDistance(
                  Eigen::Quaterniond(Eigen::AngleAxisd(expected, Eigen::Vector3d::UnitY()))),
              1e-9);
    expected += 0.1;
  }
}

TEST(OdometryTimeline, KeepsTheWayOfHoursWithinBounds) {
  OdometryTimeline bounded(false);
  Motion whole;
  const int samples = 50000;
  for (int i = 0; i <= samples; ++i) {
    bounded.push(twist(0.01 * i, 1.0, 0.002));
    OdometryStep step;
    step.forward = 0.01;
    step.rotation = 0.00002;
    if (i > 0) whole.add(step);
  }
  const auto steps = bounded.advanceTo(stampFromSeconds(0.01 * samples));
  EXPECT_LE(steps.size(), 20001U);
  const Motion told = sumOf(steps);
  EXPECT_NEAR(told.pose.x, whole.pose.x, 1e-6);
  EXPECT_NEAR(told.pose.y, whole.pose.y, 1e-6);
  EXPECT_NEAR(told.pose.yaw, whole.pose.yaw, 1e-9);
}

}  // namespace
}  // namespace ratslam
