#include "ratslam/system/map_stage.h"

#include <gtest/gtest.h>

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
  MapStage stage(ExperienceMapParams{}, false);
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

}  // namespace
}  // namespace ratslam
