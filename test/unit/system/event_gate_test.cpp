#include "ratslam/system/event_gate.h"

#include <gtest/gtest.h>

#include <cstdlib>

namespace ratslam {
namespace {

constexpr Stamp kTenth = 100000000;

struct Event {
  Stamp stamp = 0;
};

OdometrySample forward(Stamp stamp) {
  OdometrySample sample;
  sample.stamp = stamp;
  sample.speed = 1.0;
  return sample;
}

/// Way driven by the events of a recording of 5 s that is played twice, the odometry `ahead` samples before
/// the events, or behind them where that is negative.
std::vector<double> waysOfALoop(int ahead) {
  constexpr int kLap = 50;
  constexpr int kAll = 2 * kLap;
  EventGate<Event> gate(false);
  std::vector<double> ways;
  const auto stampOf = [](int k) { return 100 * kTenth + k % kLap * kTenth; };
  for (int k = -std::abs(ahead); k < kAll + std::abs(ahead); ++k) {
    const int sample = ahead >= 0 ? k + ahead : k;
    const int event_number = ahead >= 0 ? k : k - ahead;
    if (sample >= 0 && sample < kAll) gate.addOdometry(forward(stampOf(sample)));
    if (event_number >= 0 && event_number < kAll) gate.addEvent({stampOf(event_number)});
    while (const Event* event = gate.ready()) {
      double way = 0.0;
      for (const TimedStep& timed : gate.motionUntil(event->stamp)) way += timed.step.forward;
      ways.push_back(way);
      gate.pop();
    }
  }
  return ways;
}

TEST(EventGate, ALoopedRecordingGivesTheSameHoweverFarTheOdometryRunsAheadOrBehind) {
  const std::vector<double> together = waysOfALoop(0);
  ASSERT_EQ(together.size(), 100U);
  for (const int ahead : {1, 7, 45, 49, -1, -7, -30, -49, -70}) {
    EXPECT_EQ(waysOfALoop(ahead), together) << ahead << " samples ahead";
  }
}

/// Images that come out of order by more than time_reset, or whose clock steps back alone: the odometry never goes back.
TEST(EventGate, EventsThatAloneGoBackPassOnceTheyAreBeyondTheOdometryAgain) {
  EventGate<Event> gate(false);
  std::vector<Stamp> passed;
  double way = 0.0;
  for (int k = 100; k < 150; ++k) {
    gate.addOdometry(forward(k * kTenth));
    gate.addEvent({k * kTenth});
    while (const Event* event = gate.ready()) {
      passed.push_back(event->stamp);
      for (const TimedStep& timed : gate.motionUntil(event->stamp)) way += timed.step.forward;
      gate.pop();
    }
    if (k == 120) gate.addEvent({105 * kTenth});  // and those of the old time go on
  }
  EXPECT_EQ(passed.size(), 51U);
  EXPECT_FALSE(gate.waitsForOdometryToGoBack());
  EXPECT_NEAR(way, 4.9, 1e-9) << "what was driven meanwhile is driven once";
}

}  // namespace
}  // namespace ratslam
