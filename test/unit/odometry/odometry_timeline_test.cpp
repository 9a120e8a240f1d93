#include "ratslam/odometry/odometry_timeline.h"

#include <gtest/gtest.h>

#include <limits>

#include "ratslam/common/pose2.h"
#include "ratslam/system/event_gate.h"

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
  EXPECT_EQ(timeline.push(twist(1.0, nan, 0.0)), SampleVerdict::kNotFinite);
  EXPECT_EQ(timeline.push(twist(1.0, 0.0, infinity)), SampleVerdict::kNotFinite);
  EXPECT_EQ(timeline.push(twist(0.0, 1.0, 1.0)), SampleVerdict::kRepeatedStamp);
  EXPECT_EQ(timeline.push(twist(-1.0, 1.0, 1.0)), SampleVerdict::kTimeWentBack);
  timeline.push(twist(2.0, 3.0, 0.0));
  const auto steps = timeline.advanceTo(2 * kSecond);
  ASSERT_EQ(steps.size(), 1U);
  EXPECT_DOUBLE_EQ(steps[0].step.forward, 6.0);
}

struct Event {
  Stamp stamp;
};

double distance(const std::vector<TimedStep>& steps) {
  double sum = 0.0;
  for (const TimedStep& timed : steps) sum += timed.step.forward;
  return sum;
}

/// Events and odometry of ten seconds at 1 m/s, handed over in a given interleaving; the motion before each
/// event.
std::vector<double> motionPerEvent(std::size_t odometry_first) {
  EventGate<Event> gate(false);
  std::vector<double> motions;
  const auto drain = [&] {
    while (const Event* event = gate.ready()) {
      motions.push_back(distance(gate.motionUntil(event->stamp)));
      gate.pop();
    }
  };
  std::size_t odometry = 0;
  for (std::size_t event = 0; event < 9; ++event) {
    for (; odometry < 41 && odometry < odometry_first + event; ++odometry) {
      gate.addOdometry(twist(0.25 * static_cast<double>(odometry), 1.0, 0.0));
      drain();
    }
    gate.addEvent({static_cast<Stamp>(event) * kSecond + kSecond / 10});
    drain();
  }
  for (; odometry < 41; ++odometry) {
    gate.addOdometry(twist(0.25 * static_cast<double>(odometry), 1.0, 0.0));
    drain();
  }
  return motions;
}

TEST(EventGate, ArrivalOrderDoesNotMatter) {
  const auto expected = motionPerEvent(41);
  ASSERT_EQ(expected.size(), 9U);
  EXPECT_NEAR(expected[0], 0.1, 1e-12);
  EXPECT_NEAR(expected[5], 1.0, 1e-12);
  for (std::size_t lead = 0; lead < 41; ++lead) EXPECT_EQ(motionPerEvent(lead), expected) << "lead " << lead;
}

TEST(EventGate, NoMotionIsMeasuredAcrossAJumpBackInTime) {
  for (const bool events_jump_first : {true, false}) {
    EventGate<Event> gate(false);
    for (int i = 0; i <= 10; ++i) gate.addOdometry(twist(i, 1.0, 0.0));
    gate.addEvent({10 * kSecond});
    gate.motionUntil(10 * kSecond);
    gate.pop();
    if (events_jump_first) {
      EXPECT_FALSE(gate.addEvent({kSecond}));
      EXPECT_EQ(gate.ready(), nullptr) << "the odometry has not gone back yet";
      EXPECT_TRUE(gate.motionUntil(kSecond).empty());
    }
    EXPECT_EQ(gate.addOdometry(twist(0.0, 1.0, 0.0)), SampleVerdict::kTimeWentBack);
    if (!events_jump_first) {
      EXPECT_FALSE(gate.addEvent({kSecond}));
    }
    EXPECT_EQ(gate.ready(), nullptr);
    gate.addOdometry(twist(1.0, 1.0, 0.0));
    ASSERT_NE(gate.ready(), nullptr);
    EXPECT_DOUBLE_EQ(distance(gate.motionUntil(kSecond)), 1.0);
  }
}

}  // namespace
}  // namespace ratslam
