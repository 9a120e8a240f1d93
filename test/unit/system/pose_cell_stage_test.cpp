#include "ratslam/system/pose_cell_stage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace ratslam {
namespace {

constexpr Stamp kSecond = 1'000'000'000;

TEST(PoseCellStage, AViewThatCannotBeUsedTakesNoDecisionWithIt) {
  PoseCellStage stage{PoseCellParams{}};
  const auto view = [](int index, double relative_rad) {
    ViewEvent event;
    event.stamp = index * kSecond;
    event.id = static_cast<std::uint32_t>(index);
    event.relative_rad = relative_rad;
    return event;
  };
  stage.addView(view(1, 0.0));
  EXPECT_THROW(stage.addView(view(2, std::numeric_limits<double>::quiet_NaN())), std::invalid_argument);
  stage.addView(view(3, 0.0));
  for (int index = 0; index < 5; ++index) {
    OdometrySample sample;
    sample.stamp = index * kSecond;
    sample.speed = 1.0;
    stage.addOdometry(sample);
  }
  const auto decisions = stage.drain();
  ASSERT_EQ(decisions.size(), 2U);
  EXPECT_EQ(decisions[0].view.id, 1U);
  EXPECT_EQ(decisions[1].view.id, 3U);
}

// A view that waits may be dropped, so its stamp is none that a change can wait for.
TEST(PoseCellStage, AChangeHoldsAfterTheLastViewThatWasProcessed) {
  PoseCellStage stage{PoseCellParams{}};
  for (const int index : {1, 2, 900}) {
    ViewEvent event;
    event.stamp = index * kSecond;
    stage.addView(event);
  }
  for (int index = 0; index < 4; ++index) {
    OdometrySample sample;
    sample.stamp = index * kSecond;
    stage.addOdometry(sample);
  }
  ASSERT_EQ(stage.drain().size(), 2U);
  ASSERT_EQ(stage.waitingViews(), 1U);
  EXPECT_EQ(stage.latestProcessed(), 2 * kSecond);
}

/// A drive along new views with numbers from 0 on.
void driveNewStreet(PoseCellStage& stage, std::uint32_t views) {
  for (std::uint32_t index = 0; index < views; ++index) {
    OdometrySample sample;
    sample.stamp = (index + 1) * kSecond;
    sample.speed = 3.0;
    stage.addOdometry(sample);
    ViewEvent event;
    event.stamp = sample.stamp;
    event.id = index;
    event.session = {kSecond, 0};
    stage.addView(event);
    stage.drain();
  }
}

/// A robot that wakes up where it fell asleep, or nearby, turns activity to the place that it sees.
TEST(PoseCellStage, ThePlaceWhereTheLastDriveEndedIsRecalledInTheNextOne) {
  constexpr std::uint32_t kViews = 40;
  for (const bool interrupted : {false, true}) {
    PoseCellStage stage{PoseCellParams{}};
    driveNewStreet(stage, kViews);
    if (interrupted) stage.interrupt();  // otherwise the stamps go back: another lap
    OdometrySample sample;
    sample.stamp = kSecond;
    sample.speed = 0.0;
    stage.addOdometry(sample);
    const PoseCellEstimate slept = stage.cells().estimate();
    std::vector<PoseCellDecision> decisions;
    for (int look = 0; look < 12; ++look) {  // of the last but five, without moving
      sample.stamp += kSecond;
      stage.addOdometry(sample);
      ViewEvent event;
      event.stamp = sample.stamp;
      event.id = kViews - (look % 2 == 0 ? 5 : 6);
      event.session = {kSecond, 0};
      stage.addView(event);
      for (const PoseCellDecision& decision : stage.drain()) decisions.push_back(decision);
    }
    ASSERT_EQ(decisions.size(), 12U);
    const PoseCellEstimate here = decisions.back().estimate;
    EXPECT_GT(std::abs(here.x - slept.x) + std::abs(here.y - slept.y), 1.0) << interrupted;
  }
}

}  // namespace
}  // namespace ratslam
