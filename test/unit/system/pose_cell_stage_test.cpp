#include "ratslam/system/pose_cell_stage.h"

#include <gtest/gtest.h>

#include <limits>

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

}  // namespace
}  // namespace ratslam
