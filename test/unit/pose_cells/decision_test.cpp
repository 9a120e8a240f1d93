/// View input and experience selection.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "against_oracle.h"
#include "ratslam/common/state.h"
#include "ratslam/pose_cells/pose_cells.h"

namespace ratslam {
namespace {

ViewEvent view(std::uint32_t id, double relative_rad = 0.0) {
  ViewEvent event;
  event.id = id;
  event.relative_rad = relative_rad;
  return event;
}

TEST(ViewInput, OnlyViewsThatAreNotYoungInject) {
  ViewInput input{PoseCellParams{}};
  for (std::uint32_t id = 0; id < 10; ++id) EXPECT_FALSE(input.onView(view(100 + 7 * id), {}));
  EXPECT_FALSE(input.onView(view(100), {}));  // ten are known, all of them young
  EXPECT_FALSE(input.onView(view(9), {}));    // the eleventh, although its number is the lowest
  EXPECT_TRUE(input.onView(view(100), {}));
  EXPECT_FALSE(input.onView(view(107), {}));
}

TEST(ViewInput, AfterWakingUpAllKnownViewsInjectAndNewOnesAreYoungAgain) {
  for (const bool saved : {false, true}) {
    ViewInput input{PoseCellParams{}};
    for (std::uint32_t id = 0; id < 20; ++id) input.onView(view(id), {});
    EXPECT_FALSE(input.onView(view(19), {}));
    input.forgetFrom(18);
    input.wakeUp();
    input.forgetFrom(17);
    if (saved) {
      State state;
      input.save(state);
      input = ViewInput{PoseCellParams{}};
      input.load(State::fromBytes(state.toBytes()));
    }
    EXPECT_FALSE(input.onView(view(40), {})) << "new";
    EXPECT_FALSE(input.onView(view(40), {})) << "young";
    EXPECT_TRUE(input.onView(view(16), {}));
    EXPECT_FALSE(input.onView(view(17), {})) << "another view with this number, tied since then";
    EXPECT_FALSE(input.onView(view(17), {}));
  }
}

/// A robot that has stood at its dock all night knows the dock in the morning.
TEST(ViewInput, AfterWakingUpViewsAreAtRest) {
  ViewInput input{PoseCellParams{}};
  for (std::uint32_t id = 0; id < 20; ++id) input.onView(view(id), {});
  const double rested = input.onView(view(0), {})->energy;
  for (int look = 0; look < 1000; ++look) input.onView(view(0), {});
  EXPECT_FALSE(input.onView(view(0), {}));
  input.wakeUp();
  const auto injection = input.onView(view(0), {});
  ASSERT_TRUE(injection);
  EXPECT_EQ(injection->energy, rested);
}

TEST(ViewInput, InjectsWhereTheViewWasTiedTurnedByTheRelativeHeading) {
  for (const bool truncated : {false, true}) {
    PoseCellParams params;
    params.openratslam_injection = truncated;
    ViewInput input{params};
    input.onView(view(0), {3.9, 20.2, 35.5});
    for (std::uint32_t id = 1; id < 11; ++id) input.onView(view(id), {});
    const auto injection = input.onView(view(0, 2.0 * kPi / 36.0), {});
    ASSERT_TRUE(injection);
    EXPECT_EQ(injection->where.x, truncated ? 3.0 : 3.9);
    EXPECT_EQ(injection->where.y, truncated ? 20.0 : 20.2);
    EXPECT_NEAR(injection->where.th, truncated ? 0.0 : 0.5, 1e-12);
    EXPECT_NEAR(injection->energy, 0.15 * (30.0 - std::exp(1.2)) / 30.0, 1e-15);
  }
}

/// A robot that drives on along a street it knows, by its views alone, is at each of the street's places.
TEST(PoseCells, OnAKnownStreetEachPlaceIsRecalled) {
  for (const bool truncated : {false, true}) {
    PoseCellParams params;
    params.n_xy = 30;
    params.cell_size = 2.0;
    params.restore = 0.04;
    params.experience_distance = 1.0;
    params.openratslam_injection = truncated;
    PoseCells cells(params);
    constexpr int kPlaces = 60;
    const auto drive = [&](std::uint32_t id) {
      cells.activate(view(id));
      cells.integrate(0.9, 0.0);
      return cells.decide().kind;
    };
    // To most of a cell beyond whole numbers, so that the cell of these numbers is far.
    cells.integrate(0.0, 0.5 * kPi);
    cells.integrate(1.6, 0.0);
    cells.integrate(0.0, -0.5 * kPi - 0.03);
    for (std::uint32_t id = 0; id < kPlaces; ++id) EXPECT_EQ(drive(id), ActionKind::kCreateNode);
    cells.integrate(7.3, 1.9);  // round the block, out of sight
    for (std::uint32_t id = 1000; id < 1030; ++id) drive(id);
    cells.integrate(0.0, 2.0 * kPi - 1.9);
    int recalled = 0;
    for (std::uint32_t id = 0; id < kPlaces; ++id) recalled += drive(id) == ActionKind::kCreateEdge ? 1 : 0;
    if (truncated) {
      EXPECT_LT(recalled, kPlaces / 2);
    } else {
      EXPECT_GE(recalled, kPlaces - 12);  // the packet needs some views to get there
    }
  }
}

TEST(ViewInput, ARepeatedViewFallsSilentAndRecovers) {
  PoseCellParams params;
  ViewInput input(params);
  for (std::uint32_t id = 0; id < 12; ++id) input.onView(view(id), {});
  double last = input.onView(view(0), {})->energy;
  const double rested = last;
  int repetitions = 0;
  for (; repetitions < 10; ++repetitions) {
    const auto injection = input.onView(view(0), {});
    if (!injection) break;
    EXPECT_LT(injection->energy, last);
    last = injection->energy;
  }
  EXPECT_EQ(repetitions, 1);  // 1, 1.95, then 2.9: exp(1.2 * 2.9) > 30
  for (int event = 0; event < 40; ++event) input.onView(view(11), {});
  EXPECT_EQ(input.onView(view(0), {})->energy, rested);
}

/// Saturation is brought up to date lazily; the plain implementation sweeps all views at each event.
TEST(ViewInput, EqualsTheSweep) {
  PoseCellParams params;
  params.n_xy = 9;
  params.n_th = 12;
  params.active_decay = 0.3;
  params.restore = 0.07;
  params.openratslam_injection = true;
  PoseCells fast(params);
  oracle::PoseCells plain(params);
  std::mt19937 random(3);
  for (int frame = 0; frame < 400; ++frame) {
    fast.integrate(0.4, 0.05);
    plain.integrate(0.4, 0.05);
    // Runs of one view, from few enough for repetitions.
    const std::uint32_t id = frame % 5 < 3 ? static_cast<std::uint32_t>(frame / 5 % 13)
                                           : static_cast<std::uint32_t>(random() % 20);
    const ViewEvent event = view(id, 0.3 * (frame % 4));
    fast.activate(event);
    plain.activate(event);
    ASSERT_LT(largestDifference(fast.activity(), plain.network), 1e-10) << "frame " << frame;
    const TopologicalAction ours = fast.decide();
    const TopologicalAction theirs = plain.decide();
    ASSERT_EQ(ours.kind, theirs.kind) << "frame " << frame;
    ASSERT_EQ(ours.dest_id, theirs.dest_id) << "frame " << frame;
    ASSERT_EQ(ours.relative_rad, theirs.relative_rad) << "frame " << frame;
  }
}

TEST(ExperienceSelector, ANewViewIsANewExperience) {
  ExperienceSelector selector{PoseCellParams{}};
  const TopologicalAction first = selector.select(view(5), {10, 10, 10});
  EXPECT_EQ(first.kind, ActionKind::kCreateNode);
  EXPECT_EQ(first.dest_id, 0U);
  const TopologicalAction same = selector.select(view(5), {10.5, 10, 10});
  EXPECT_EQ(same.kind, ActionKind::kNone);
  EXPECT_EQ(same.dest_id, 0U);
  const TopologicalAction second = selector.select(view(6), {10.5, 10, 10});
  EXPECT_EQ(second.kind, ActionKind::kCreateNode);
  EXPECT_EQ(second.src_id, 0U);
  EXPECT_EQ(second.dest_id, 1U);
}

TEST(ExperienceSelector, AKnownViewAtAKnownPlaceClosesTheLoop) {
  ExperienceSelector selector{PoseCellParams{}};
  selector.select(view(5), {0.2, 20.9, 35.8});
  selector.select(view(6), {5, 5, 5});
  const TopologicalAction closed = selector.select(view(5), {20.9, 0.1, 0.3});  // across all three seams
  EXPECT_EQ(closed.kind, ActionKind::kCreateEdge);
  EXPECT_EQ(closed.src_id, 1U);
  EXPECT_EQ(closed.dest_id, 0U);
}

TEST(ExperienceSelector, AKnownViewElsewhereIsANewExperience) {
  ExperienceSelector selector{PoseCellParams{}};
  selector.select(view(5), {10, 10, 10});
  EXPECT_EQ(selector.select(view(5), {13, 10, 10}).kind, ActionKind::kCreateNode);  // moved on
  selector.select(view(6), {15, 10, 10});
  EXPECT_EQ(selector.select(view(5), {10, 14, 10}).kind, ActionKind::kCreateNode);  // elsewhere
  EXPECT_EQ(selector.select(view(6), {15.4, 10, 10}).dest_id, 2U);
  const TopologicalAction nearest = selector.select(view(5), {12.3, 10, 10});
  EXPECT_EQ(nearest.kind, ActionKind::kCreateEdge);
  EXPECT_EQ(nearest.dest_id, 1U);  // 0.7 away, not 2.3
}

TEST(ExperienceSelector, TheSamePlaceSeenTurnedIsTheSamePlace) {
  ExperienceSelector selector{PoseCellParams{}};
  const double layer = 2.0 * kPi / 36.0;
  selector.select(view(5), {10, 10, 10});
  selector.select(view(6), {14, 10, 10});
  const TopologicalAction turned = selector.select(view(5, 9 * layer), {10, 10, 19});
  EXPECT_EQ(turned.kind, ActionKind::kCreateEdge);
  EXPECT_EQ(turned.dest_id, 0U);
  EXPECT_NEAR(turned.relative_rad, 9 * layer, 1e-12);
}

TEST(ExperienceSelector, AnExperienceCreatedTurnedIsRecognisedAtOnce) {
  ExperienceSelector selector{PoseCellParams{}};
  const double layer = 2.0 * kPi / 36.0;
  const TopologicalAction created = selector.select(view(5, 9 * layer), {10, 10, 19});
  EXPECT_EQ(created.kind, ActionKind::kCreateNode);
  EXPECT_EQ(created.relative_rad, 0.0);  // it faces where the robot faces
  EXPECT_EQ(selector.select(view(5, 9 * layer), {10, 10, 19}).kind, ActionKind::kNone);
}

/// A way of three cells under one view, driven over and over in steps of a sixteenth of a cell.
std::vector<std::size_t> experiencesOverVisits(double density, int visits) {
  PoseCellParams params;
  params.experience_density = density;
  ExperienceSelector selector(params);
  std::vector<std::size_t> counts;
  for (int visit = 0; visit < visits; ++visit) {
    for (int step = 0; step <= 48; ++step) selector.select(view(5), {5.0 + step / 16.0, 10, 10});
    selector.select(view(6), {15, 10, 10});
    counts.push_back(selector.size());
  }
  return counts;
}

TEST(ExperienceSelector, TheMapGrowsDenserWithTheLogarithmOfTheVisits) {
  const std::vector<std::size_t> off = experiencesOverVisits(0.0, 1000);
  EXPECT_EQ(off.front(), off.back());
  const std::vector<std::size_t> on = experiencesOverVisits(1.0, 1000);
  EXPECT_EQ(on.front(), off.front());
  // By the law the way holds 3 / D(n) experiences, D(n) = 2 / (1 + ln(1 + n)).
  for (const int visits : {10, 30, 100, 300, 1000}) {
    const double by_law = 3.0 / 2.0 * (1.0 + std::log1p(visits));
    const auto count = static_cast<double>(on[static_cast<std::size_t>(visits) - 1]);
    EXPECT_GT(count, 0.5 * by_law) << visits << " visits";
    EXPECT_LT(count, 2.0 * by_law + 3.0) << visits << " visits";
  }
}

/// What is made while a view stays was not told by the view, and is no place to recall.
TEST(ExperienceSelector, ADenserMapIsRecalledWhereAViewBegan) {
  PoseCellParams params;
  params.experience_density = 1.0;
  ExperienceSelector selector(params);
  const auto way = [&selector] {
    for (int step = 0; step <= 16; ++step) selector.select(view(5), {5.0 + step / 16.0, 10, 10});
    selector.select(view(6), {15, 10, 10});
  };
  for (int visit = 0; visit < 50; ++visit) way();
  ASSERT_GT(selector.size(), 3U);
  EXPECT_EQ(selector.select(view(5), {5.1, 10, 10}).dest_id, 0U);
  const TopologicalAction within = selector.select(view(5), {6, 10, 10});
  EXPECT_EQ(within.kind, ActionKind::kSetNode);
  EXPECT_NE(within.dest_id, 0U);
  selector.select(view(6), {15, 10, 10});
  const TopologicalAction elsewhere = selector.select(view(5), {6, 10, 10});
  EXPECT_EQ(elsewhere.kind, ActionKind::kCreateNode) << "the view has never become active there";
  selector.select(view(6), {15, 10, 10});

  State state;
  selector.save(state);
  ExperienceSelector again(params);
  again.load(State::fromBytes(state.toBytes()));
  const TopologicalAction recall = again.select(view(5), {6, 10, 10});
  EXPECT_EQ(recall.kind, ActionKind::kCreateEdge);
  EXPECT_EQ(recall.dest_id, elsewhere.dest_id);
}

/// Where the robot parked, too: the map must learn that it is there again.
TEST(ExperienceSelector, AfterWakingUpTheLastPlaceIsRecalledAsAnyOther) {
  for (const bool saved : {false, true}) {
    ExperienceSelector selector{PoseCellParams{}};
    selector.select(view(5), {10, 10, 10});
    selector.select(view(6), {15, 10, 10});
    selector.wakeUp();
    EXPECT_EQ(selector.stay(0).kind, ActionKind::kNone);
    if (saved) {
      State state;
      selector.save(state);
      selector = ExperienceSelector{PoseCellParams{}};
      selector.load(State::fromBytes(state.toBytes()));
    }
    const TopologicalAction recall = selector.select(view(6), {15, 10, 10});
    EXPECT_EQ(recall.kind, ActionKind::kCreateEdge);
    EXPECT_EQ(recall.dest_id, 1U);
    EXPECT_EQ(selector.select(view(6), {15, 10, 10}).kind, ActionKind::kNone);
  }
}

TEST(ExperienceSelector, WithoutLearningVisitsDoNotCount) {
  PoseCellParams params;
  params.experience_density = 1.0;
  ExperienceSelector selector(params);
  selector.select(view(5), {10, 10, 10});
  selector.setLearning(false);
  for (int visit = 0; visit < 100; ++visit) {
    selector.select(view(6), {15, 10, 10});
    EXPECT_EQ(selector.select(view(5), {11, 10, 10}).kind, ActionKind::kNone) << visit << " visits";
  }
}

TEST(PoseCells, NothingToDecideBeforeTheFirstView) {
  PoseCells pose_cells{PoseCellParams{}};
  pose_cells.integrate(0.5, 0.0);
  EXPECT_EQ(pose_cells.decide().kind, ActionKind::kNone);
}

TEST(PoseCells, RefusesARelativeHeadingThatIsNotFinite) {
  PoseCells pose_cells{PoseCellParams{}};
  EXPECT_THROW(pose_cells.activate(view(0, std::numeric_limits<double>::infinity())), std::invalid_argument);
  pose_cells.activate(view(0, 1e300));
  EXPECT_EQ(pose_cells.decide().kind, ActionKind::kCreateNode);
}

}  // namespace
}  // namespace ratslam
