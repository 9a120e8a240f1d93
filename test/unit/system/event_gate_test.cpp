#include "ratslam/system/event_gate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr Stamp kSecond = 1000000000;
constexpr Stamp kTenth = kSecond / 10;

struct Event {
  Stamp stamp = 0;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("stamp", stamp);
  }
};

/// An event that has passed, and the way driven since the one before it [m].
struct Passed {
  Stamp stamp = 0;
  double way = 0.0;
};

bool operator==(const Passed& a, const Passed& b) { return a.stamp == b.stamp && a.way == b.way; }

OdometrySample forward(Stamp stamp, double speed = 1.0) {
  OdometrySample sample;
  sample.stamp = stamp;
  sample.speed = speed;
  return sample;
}

void pass(EventGate<Event>& gate, std::vector<Passed>& passed, Passing which = Passing::kReached) {
  gate.pass(which, [&](const Event& event) {
    passed.push_back({event.stamp, 0.0});
    for (const TimedStep& timed : gate.motionUntil(event.stamp)) passed.back().way += timed.step.forward;
    return true;
  });
}

std::vector<Passed> passed(EventGate<Event>& gate) {
  std::vector<Passed> all;
  pass(gate, all);
  return all;
}

/// The events of a recording of 5 s that is played twice, the odometry `ahead` samples before
/// the events, or behind them where that is negative.
std::vector<Passed> eventsOfALoop(int ahead) {
  constexpr int kLap = 50;
  constexpr int kAll = 2 * kLap;
  EventGate<Event> gate(false);
  std::vector<Passed> all;
  const auto stampOf = [](int k) { return 100 * kTenth + k % kLap * kTenth; };
  for (int k = -std::abs(ahead); k < kAll + std::abs(ahead); ++k) {
    const int sample = ahead >= 0 ? k + ahead : k;
    const int event_number = ahead >= 0 ? k : k - ahead;
    if (sample >= 0 && sample < kAll) gate.addOdometry(forward(stampOf(sample)));
    if (event_number >= 0 && event_number < kAll) gate.addEvent({stampOf(event_number)});
    pass(gate, all);
  }
  return all;
}

TEST(EventGate, ALoopedRecordingGivesTheSameHoweverFarTheOdometryRunsAheadOrBehind) {
  const std::vector<Passed> together = eventsOfALoop(0);
  ASSERT_EQ(together.size(), 100U);
  for (const int ahead : {1, 7, 45, 49, -1, -7, -30, -49, -70}) {
    EXPECT_TRUE(eventsOfALoop(ahead) == together) << ahead << " samples ahead";
  }
}

/// Images that come out of order by more than odometry_reset, or whose clock steps back alone: the odometry never goes back.
TEST(EventGate, EventsThatAloneGoBackPassOnceTheyAreBeyondTheOdometryAgain) {
  EventGate<Event> gate(false);
  std::vector<Passed> all;
  for (int k = 100; k < 150; ++k) {
    gate.addOdometry(forward(k * kTenth));
    gate.addEvent({k * kTenth});
    pass(gate, all);
    if (k == 120) gate.addEvent({105 * kTenth});  // and those of the old time go on
  }
  EXPECT_EQ(all.size(), 51U);
  EXPECT_FALSE(gate.waitsForOdometryToGoBack());
  double way = 0.0;
  for (const Passed& event : all) way += event.way;
  EXPECT_NEAR(way, 4.9, 1e-9) << "what was driven meanwhile is driven once";
}

/// Events and odometry of ten seconds at 1 m/s, the odometry so many samples ahead of the events.
std::vector<Passed> eventsOfTenSeconds(std::size_t odometry_first) {
  EventGate<Event> gate(false);
  std::vector<Passed> all;
  std::size_t odometry = 0;
  const auto addNext = [&] { gate.addOdometry(forward(static_cast<Stamp>(odometry++) * kSecond / 4)); };
  for (std::size_t event = 0; event < 9; ++event) {
    while (odometry < 41 && odometry < odometry_first + event) {
      addNext();
      pass(gate, all);
    }
    gate.addEvent({static_cast<Stamp>(event) * kSecond + kTenth});
    pass(gate, all);
  }
  while (odometry < 41) {
    addNext();
    pass(gate, all);
  }
  return all;
}

TEST(EventGate, ArrivalOrderDoesNotMatter) {
  const auto expected = eventsOfTenSeconds(41);
  ASSERT_EQ(expected.size(), 9U);
  EXPECT_NEAR(expected[0].way, 0.1, 1e-12);
  EXPECT_NEAR(expected[5].way, 1.0, 1e-12);
  for (std::size_t lead = 0; lead < 41; ++lead) {
    EXPECT_TRUE(eventsOfTenSeconds(lead) == expected) << "lead " << lead;
  }
}

TEST(EventGate, NoMotionIsMeasuredAcrossAJumpBackInTime) {
  for (const bool events_jump_first : {true, false}) {
    EventGate<Event> gate(false);
    for (int i = 0; i <= 10; ++i) gate.addOdometry(forward(i * kSecond));
    gate.addEvent({10 * kSecond});
    ASSERT_EQ(passed(gate).size(), 1U);
    if (events_jump_first) {
      EXPECT_EQ(gate.addEvent({kSecond}), EventVerdict::kTimeWentBack);
      EXPECT_TRUE(passed(gate).empty()) << "the odometry has not gone back yet";
    }
    EXPECT_EQ(gate.addOdometry(forward(0)), SampleVerdict::kTimeWentBack);
    if (!events_jump_first) {
      EXPECT_EQ(gate.addEvent({kSecond}), EventVerdict::kTimeWentBack);
    }
    EXPECT_TRUE(passed(gate).empty());
    gate.addOdometry(forward(kSecond));
    EXPECT_TRUE(passed(gate) == std::vector<Passed>({{kSecond, 1.0}}));
  }
}

/// What an event waits for beside the odometry comes late (recall geometry); meanwhile both streams go back.
TEST(EventGate, EventsThatAreReachedButNotYetTakenOutlastAJumpBack) {
  for (const bool odometry_jumps_first : {true, false}) {
    EventGate<Event> gate(false);
    for (int i = 0; i <= 10; ++i) gate.addOdometry(forward(i * kSecond));
    gate.addEvent({9 * kSecond});
    gate.addEvent({10 * kSecond});
    gate.pass(Passing::kReached, [](const Event&) { return false; });
    const auto jump = [&](bool odometry) {
      if (odometry) {
        for (int i = 0; i <= 3; ++i) gate.addOdometry(forward(i * kSecond));
      } else {
        EXPECT_EQ(gate.addEvent({2 * kSecond}), EventVerdict::kTimeWentBack);
      }
    };
    jump(odometry_jumps_first);
    jump(!odometry_jumps_first);
    const std::vector<Passed> expected{{9 * kSecond, 9.0}, {10 * kSecond, 1.0}, {2 * kSecond, 2.0}};
    EXPECT_TRUE(passed(gate) == expected) << odometry_jumps_first;
  }
}

TEST(EventGate, ASilentOdometryHoldsNothingUpThatIsNotWaitedFor) {
  EventGate<Event> gate(false);
  for (int i = 0; i <= 2; ++i) gate.addOdometry(forward(i * kSecond));
  for (int i = 1; i <= 4; ++i) gate.addEvent({i * kSecond});
  std::vector<Passed> all;
  pass(gate, all);
  EXPECT_EQ(all.size(), 2U);
  pass(gate, all, Passing::kAll);
  EXPECT_TRUE(all == std::vector<Passed>(
                         {{kSecond, 1.0}, {2 * kSecond, 1.0}, {3 * kSecond, 0.0}, {4 * kSecond, 0.0}}));
}

TEST(EventGate, AnEventAtWhichItsTakerThrowsHoldsUpNoOther) {
  EventGate<Event> gate(false);
  for (int i = 0; i <= 2; ++i) gate.addOdometry(forward(i * kSecond));
  gate.addEvent({kSecond});
  gate.addEvent({2 * kSecond});
  EXPECT_THROW(gate.pass(Passing::kReached, [](const Event&) -> bool { throw std::invalid_argument("bad"); }),
               std::invalid_argument);
  EXPECT_TRUE(passed(gate) == std::vector<Passed>({{2 * kSecond, 2.0}}));
}

TEST(EventGate, ASecondPublisherWhoseStampsLieBackChangesNothing) {
  EventGate<Event> alone(false);
  EventGate<Event> disturbed(false);
  for (int i = 200; i < 260; ++i) {
    for (EventGate<Event>* gate : {&alone, &disturbed}) gate->addOdometry(forward(i * kTenth));
    disturbed.addOdometry(forward((i - 130) * kTenth, 5.0));
    for (EventGate<Event>* gate : {&alone, &disturbed}) gate->addEvent({i * kTenth});
    const std::vector<Passed> expected = passed(alone);
    ASSERT_EQ(expected.size(), 1U);
    EXPECT_TRUE(passed(disturbed) == expected);
  }
  EXPECT_EQ(disturbed.beginnings(), 0U);
}

/// Events and odometry of six seconds; sample `wrong` lies ahead by so much, or is missing where `ahead` is zero.
std::vector<Passed> eventsWithAnOutlier(int wrong, Stamp ahead, bool saved, EventGate<Event>& gate) {
  std::vector<Passed> all;
  for (int k = 100; k < 160; ++k) {
    const Stamp stamp = k * kTenth;
    if (k != wrong) gate.addOdometry(forward(stamp, 1.0 + 0.01 * k));
    if (k == wrong && ahead != 0) gate.addOdometry(forward(stamp + ahead, 7.0));
    if (saved) {
      State state;
      state.set("gate", gate);
      gate = EventGate<Event>(false);
      state.get("gate", gate);
    }
    gate.addEvent({stamp});
    pass(gate, all);
  }
  gate.acceptHeld();
  pass(gate, all);
  return all;
}

TEST(EventGate, ASampleAheadOfTimeIsDroppedAndTheRestIsAsWithoutIt) {
  for (const int wrong : {100, 101, 130}) {
    EventGate<Event> clean(false);
    const std::vector<Passed> expected = eventsWithAnOutlier(wrong, 0, false, clean);
    ASSERT_EQ(expected.size(), 60U);
    for (const double seconds : {1.5, 1.95, 5.0, 60.0, 1000.0}) {
      for (const bool saved : {false, true}) {
        EventGate<Event> gate(false);
        const std::vector<Passed> all = eventsWithAnOutlier(wrong, stampFromSeconds(seconds), saved, gate);
        EXPECT_TRUE(all == expected) << "sample " << wrong << ", " << seconds << " s ahead";
        EXPECT_EQ(gate.leftBehind(), 0U);
      }
    }
  }
}

TEST(EventGate, ASampleAheadOfTimeIsNamedOnceTheNextOneShowsIt) {
  EventGate<Event> gate(false);
  gate.addOdometry(forward(0));
  EXPECT_EQ(gate.addOdometry(forward(kTenth)), SampleVerdict::kAccepted);
  EXPECT_EQ(gate.addOdometry(forward(50 * kTenth)), SampleVerdict::kHeld);
  EXPECT_EQ(gate.addOdometry(forward(2 * kTenth)), SampleVerdict::kAccepted);
  const std::vector<DecidedSample> decided = gate.takeDecided();
  ASSERT_EQ(decided.size(), 1U);
  EXPECT_EQ(decided[0].verdict, SampleVerdict::kAhead);
  EXPECT_EQ(decided[0].sample.stamp, 50 * kTenth);
}

TEST(EventGate, TimeThatDoesJumpAheadGoesOnFromThere) {
  for (const bool event_first : {false, true}) {
    EventGate<Event> gate(false);
    for (int k = 0; k < 10; ++k) gate.addOdometry(forward(k * kTenth));
    gate.addEvent({9 * kTenth});
    ASSERT_EQ(passed(gate).size(), 1U);
    if (event_first) gate.addEvent({24 * kTenth});
    const SampleVerdict verdict = gate.addOdometry(forward(24 * kTenth));
    EXPECT_EQ(verdict, event_first ? SampleVerdict::kAccepted : SampleVerdict::kHeld);
    if (!event_first) gate.addEvent({24 * kTenth});
    const std::vector<Passed> after = passed(gate);  // without waiting for another sample
    ASSERT_EQ(after.size(), 1U);
    EXPECT_NEAR(after[0].way, 1.5, 1e-9);
  }
}

TEST(EventGate, OdometryThatAloneGoesBackIsCounted) {
  EventGate<Event> gate(false);
  for (int k = 100; k < 110; ++k) {
    gate.addOdometry(forward(k * kTenth));
    gate.addEvent({k * kTenth});
  }
  for (int k = 60; k < 80; ++k) gate.addOdometry(forward(k * kTenth));
  EXPECT_EQ(gate.leftBehind(), 20U);
  EXPECT_EQ(gate.firstLeftBehind(), 60 * kTenth);
  gate.addOdometry(forward(110 * kTenth));
  EXPECT_EQ(gate.leftBehind(), 20U);
}

/// Events and odometry of six seconds, the odometry `lead` samples before the events; event `wrong` lies ahead by so much,
/// or is missing where `ahead` is zero.
std::vector<Passed> eventsOfWhichOneIsAhead(int wrong, Stamp ahead, int lead, EventGate<Event>& gate) {
  std::vector<Passed> all;
  for (int k = 100 - std::max(lead, 0); k < 160 + std::abs(lead); ++k) {
    const int sample = k + std::max(lead, 0);
    const int event = k + std::min(lead, 0);
    if (sample < 160) gate.addOdometry(forward(sample * kTenth));
    pass(gate, all);
    if (event >= 100 && event < 160 && event != wrong) gate.addEvent({event * kTenth});
    if (event == wrong && ahead != 0) gate.addEvent({event * kTenth + ahead});
    pass(gate, all);
  }
  return all;
}

TEST(EventGate, AnEventAheadOfTimeIsDroppedAndTheRestIsAsWithoutIt) {
  for (const int wrong : {100, 101, 130}) {
    EventGate<Event> clean(false);
    const std::vector<Passed> expected = eventsOfWhichOneIsAhead(wrong, 0, 0, clean);
    ASSERT_EQ(expected.size(), 59U);
    for (const double seconds : {1.5, 5.0, 1000.0}) {
      for (const int lead : {0, 3, -3}) {
        if (wrong == 100 && lead < 0) continue;  // a first event may pass before the odometry tells
        EventGate<Event> gate(false);
        const auto all = eventsOfWhichOneIsAhead(wrong, stampFromSeconds(seconds), lead, gate);
        EXPECT_TRUE(all == expected) << "event " << wrong << ", " << seconds << " s ahead, lead " << lead
                                     << ": " << all.size();
        EXPECT_EQ(gate.aheadEvents(), 1U);
      }
    }
  }
}

TEST(EventGate, NoEventIsDroppedWhereOdometryAndEventsJumpAheadTogether) {
  for (const bool odometry_first : {true, false}) {
    EventGate<Event> gate(false);
    std::vector<Passed> all;
    for (const int k : {100, 101, 102, 150, 103, 104, 105}) {  // odometry measured from the events' images
      if (odometry_first) gate.addOdometry(forward(k * kTenth));
      gate.addEvent({k * kTenth});
      if (!odometry_first) gate.addOdometry(forward(k * kTenth));
      pass(gate, all);
    }
    EXPECT_EQ(all.size(), 7U);
    EXPECT_EQ(gate.aheadEvents(), 0U);
  }
}

TEST(EventGate, ALateEventIsLeftOut) {
  EventGate<Event> gate(false);
  gate.addOdometry(forward(0));
  gate.addEvent({kSecond});
  EXPECT_EQ(gate.addEvent({kSecond / 2}), EventVerdict::kLate);
  EXPECT_EQ(gate.size(), 1U);
}

}  // namespace
}  // namespace ratslam
