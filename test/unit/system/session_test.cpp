/// A part that lost its memory, or some of it, is noticed by those who keep its numbers.
#include <gtest/gtest.h>

#include "ratslam/common/state.h"
#include "ratslam/system/map_stage.h"
#include "ratslam/system/pose_cell_stage.h"

namespace ratslam {
namespace {

constexpr Stamp kTenth = 100'000'000;

OdometrySample motion(int tick) {
  OdometrySample sample;
  sample.stamp = tick * kTenth;
  sample.speed = 10.0;
  return sample;
}

ViewEvent view(int tick, std::uint32_t id, const NumberSession& session) {
  ViewEvent event;
  event.stamp = tick * kTenth;
  event.id = id;
  event.session = session;
  return event;
}

TopologicalAction action(int tick, ActionKind kind, std::uint32_t src, std::uint32_t dest,
                         const NumberSession& session) {
  TopologicalAction result;
  result.stamp = tick * kTenth;
  result.kind = kind;
  result.src_id = src;
  result.dest_id = dest;
  result.session = session;
  return result;
}

/// Experiences that the pose cells decided to recall while views 0..n-1 came a second time at the same place.
class ViewNumbers : public testing::Test {
 protected:
  ActionKind feed(std::uint32_t view_id, const NumberSession& session) {
    ++tick_;
    OdometrySample still = motion(tick_);
    still.speed = 0.0;
    stage_.addOdometry(still);
    stage_.addView(view(tick_, view_id, session));
    const auto decisions = stage_.drain();
    return decisions.empty() ? ActionKind::kNone : decisions.back().action.kind;
  }

  PoseCellStage stage_{PoseCellParams{}};
  int tick_ = 0;
};

TEST_F(ViewNumbers, OfTheSameSessionAreRecalled) {
  const NumberSession session{kTenth, 0};
  for (std::uint32_t id = 0; id < 20; ++id) feed(id, session);
  EXPECT_EQ(feed(15, session), ActionKind::kCreateEdge);
  EXPECT_EQ(feed(3, session), ActionKind::kCreateEdge);
}

TEST_F(ViewNumbers, ThatALaterSessionGivesAgainAreNewViews) {
  for (std::uint32_t id = 0; id < 20; ++id) feed(id, {kTenth, 0});
  const NumberSession resumed{21 * kTenth, 10};  // its checkpoint held 10 templates
  EXPECT_EQ(feed(15, resumed), ActionKind::kCreateNode) << "another view than the 15 of before";
  EXPECT_EQ(feed(3, resumed), ActionKind::kCreateEdge) << "known to both";
  const NumberSession without_memory{23 * kTenth, 0};
  EXPECT_EQ(feed(3, without_memory), ActionKind::kCreateNode);
}

class ExperienceNumbers : public testing::Test {
 protected:
  void feed(ActionKind kind, std::uint32_t src, std::uint32_t dest, const NumberSession& session) {
    ++tick_;
    stage_.addOdometry(motion(tick_));
    stage_.addDecision(action(tick_, kind, src, dest, session));
    stage_.drain();
  }
  std::size_t experiences() const { return stage_.map().graph().experiences().size(); }

  MapStage stage_{ExperienceMapParams{}, GeometrySource::kNone};
  int tick_ = 0;
};

TEST_F(ExperienceNumbers, ThatALaterSessionGivesAgainAreNewPlaces) {
  const NumberSession first{kTenth, 0};
  for (std::uint32_t id = 0; id < 10; ++id) feed(ActionKind::kCreateNode, id == 0 ? 0 : id - 1, id, first);
  const NumberSession resumed{11 * kTenth, 6};
  feed(ActionKind::kCreateNode, 5, 6, resumed);
  EXPECT_EQ(experiences(), 11U);
  EXPECT_EQ(stage_.map().currentExperience(), 10U) << "not the 6 of before";
  feed(ActionKind::kCreateEdge, 6, 2, resumed);
  EXPECT_EQ(stage_.map().currentExperience(), 2U) << "known to both";
  feed(ActionKind::kCreateEdge, 2, 6, resumed);
  EXPECT_EQ(stage_.map().currentExperience(), 10U);
}

TEST_F(ExperienceNumbers, ThatAMapWithoutMemoryDoesNotKnowAreCreated) {
  const NumberSession session{kTenth, 0};
  feed(ActionKind::kCreateEdge, 70, 41, session);
  feed(ActionKind::kCreateNode, 41, 71, session);
  feed(ActionKind::kCreateEdge, 71, 42, session);
  EXPECT_EQ(experiences(), 3U);
  EXPECT_EQ(stage_.recreated(), 2U);
  feed(ActionKind::kCreateEdge, 42, 41, session);
  EXPECT_EQ(stage_.map().currentExperience(), 0U);
  EXPECT_EQ(experiences(), 3U);
}

/// A drive is played again to pose cells that were started again without memory: the first stamp is the same.
TEST_F(ExperienceNumbers, ThatAreGivenOnceMoreAreNewPlaces) {
  const NumberSession session{kTenth, 0};
  for (std::uint32_t id = 0; id < 4; ++id) feed(ActionKind::kCreateNode, id == 0 ? 0 : id - 1, id, session);
  for (std::uint32_t id = 0; id < 3; ++id) feed(ActionKind::kCreateNode, id == 0 ? 0 : id - 1, id, session);
  EXPECT_TRUE(stage_.takeRefusals().empty());
  EXPECT_EQ(experiences(), 7U);
  feed(ActionKind::kCreateEdge, 2, 1, session);
  EXPECT_EQ(stage_.map().currentExperience(), 5U);
}

/// Pose cells that know more places than the map, while nothing is to be learned.
TEST_F(ExperienceNumbers, ThatTheMapMayNotCreateStayUnknown) {
  const NumberSession session{kTenth, 0};
  for (std::uint32_t id = 0; id < 3; ++id) feed(ActionKind::kCreateNode, id == 0 ? 0 : id - 1, id, session);
  stage_.setLearning(false);
  for (const std::uint32_t id : {3U, 1U, 4U, 1U}) feed(ActionKind::kCreateEdge, 2, id, session);
  EXPECT_EQ(stage_.recreated(), 0U);
  EXPECT_EQ(experiences(), 3U);
  stage_.setLearning(true);
  feed(ActionKind::kCreateNode, 1, 5, session);
  feed(ActionKind::kCreateEdge, 5, 3, session);
  feed(ActionKind::kCreateEdge, 3, 4, session);
  EXPECT_EQ(experiences(), 6U) << "three places, each by itself";
}

TEST_F(ExperienceNumbers, OfSomebodyWhoSaysNoSessionAreTheMapsOwn) {
  feed(ActionKind::kCreateNode, 0, 0, {});
  feed(ActionKind::kCreateEdge, 0, 5, {});
  EXPECT_EQ(experiences(), 1U);
  EXPECT_EQ(stage_.takeRefusals().size(), 1U) << "there is no experience 5";
}

TEST_F(ExperienceNumbers, AreSavedWithTheMap) {
  const NumberSession session{kTenth, 0};
  feed(ActionKind::kCreateEdge, 70, 41, session);
  State state;
  stage_.save(state);
  MapStage loaded{ExperienceMapParams{}, GeometrySource::kNone};
  loaded.load(state);
  State again;
  loaded.save(again);
  EXPECT_TRUE(state == again);
}

}  // namespace
}  // namespace ratslam
