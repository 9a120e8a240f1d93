/// A robot parks, its map is saved, and it wakes up in that map where it parked or nearby.
#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <vector>

#include "ratslam/system/pipeline.h"
#include "street.h"

namespace ratslam {
namespace {

constexpr Stamp kTenth = 100'000'000;
constexpr Stamp kNextDay = 86'400'000'000'000;
constexpr int kParked = 120;  // frame at which the drive ends
constexpr int kLooks = 15;    // before and after the night

/// Each frame shows the street half a metre further on.
cv::Mat view(int frame) { return streetView(160 + 10 * 200, 10 * frame); }

struct Robot {
  explicit Robot(Stamp start) : now(start) {}

  void see(int frame, bool moves) {
    OdometrySample sample;
    sample.stamp = now;
    sample.speed = moves ? 5.0 : 0.0;
    pipeline.addOdometry(sample);
    pipeline.addImage({now, view(frame)});
    now += kTenth;
  }

  Pipeline pipeline{streetParams(), {}};
  Stamp now;
};

/// Number of parts of the map that no link joins.
std::size_t partsOf(const ExperienceMap& map) {
  std::vector<std::uint32_t> first(map.graph().experiences().size());
  std::iota(first.begin(), first.end(), 0U);
  const auto find = [&first](std::uint32_t id) {
    while (first[id] != id) id = first[id];
    return id;
  };
  std::size_t parts = first.size();
  for (const Link& link : map.graph().links()) {
    const std::uint32_t from = find(link.from);
    const std::uint32_t to = find(link.to);
    if (from != to) --parts;
    first[from] = to;
  }
  return parts;
}

TEST(WakingUp, WhereItParkedTheRobotIsInItsMapAtOnce) {
  Robot evening(0);
  for (int frame = 0; frame < kParked; ++frame) evening.see(frame, true);
  for (int look = 0; look < kLooks; ++look) evening.see(kParked, false);
  State saved;
  evening.pipeline.save(saved);
  const auto dock = evening.pipeline.map().currentExperience();
  ASSERT_TRUE(dock);

  Robot morning(kNextDay);
  morning.pipeline.load(State::fromBytes(saved.toBytes()), false);
  for (int look = 0; look < kLooks; ++look) morning.see(kParked, false);
  EXPECT_EQ(morning.pipeline.map().currentExperience(), dock);
  for (int frame = kParked + 1; frame < 200; ++frame) morning.see(frame, true);
  ASSERT_GT(morning.pipeline.map().graph().experiences().size(), *dock + 10);
  EXPECT_EQ(partsOf(morning.pipeline.map()), 1U);
}

}  // namespace
}  // namespace ratslam
