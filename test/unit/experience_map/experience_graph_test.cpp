#include "ratslam/experience_map/experience_graph.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace ratslam {
namespace {

Link linkBetween(std::uint32_t from, std::uint32_t to) {
  Link link;
  link.from = from;
  link.to = to;
  return link;
}

TEST(ExperienceGraph, ListsTheLinksOfAnExperienceByAge) {
  ExperienceGraph graph;
  for (int k = 0; k < 4; ++k) graph.addExperience(MapPose{});
  graph.addLink(linkBetween(0, 1));
  graph.addLink(linkBetween(1, 2));
  graph.addLink(linkBetween(3, 1));
  graph.addLink(linkBetween(1, 3));
  std::vector<std::uint32_t> links;
  graph.forEachLinkOf(1, [&](std::uint32_t id) { links.push_back(id); });
  EXPECT_EQ(links, (std::vector<std::uint32_t>{1, 3, 0, 2}));
}

TEST(ExperienceGraph, KnowsLinksInBothDirections) {
  ExperienceGraph graph;
  for (int k = 0; k < 3; ++k) graph.addExperience(MapPose{});
  graph.addLink(linkBetween(2, 0));
  EXPECT_TRUE(graph.linked(2, 0));
  EXPECT_TRUE(graph.linked(0, 2));
  EXPECT_FALSE(graph.linked(0, 1));
}

TEST(ExperienceGraph, RefusesLinksThatJoinNothing) {
  ExperienceGraph graph;
  graph.addExperience(MapPose{});
  graph.addExperience(MapPose{});
  const std::uint64_t before = graph.revision();
  EXPECT_THROW(graph.addLink(linkBetween(0, 2)), std::invalid_argument);
  EXPECT_THROW(graph.addLink(linkBetween(1, 1)), std::invalid_argument);
  EXPECT_TRUE(graph.links().empty());
  EXPECT_EQ(graph.revision(), before);
}

TEST(ExperienceGraph, EveryChangeOfContentIsANewRevision) {
  ExperienceGraph graph;
  std::uint64_t last = graph.revision();
  const auto changed = [&] {
    const bool grew = graph.revision() > last;
    last = graph.revision();
    return grew;
  };
  graph.addExperience(MapPose{});
  EXPECT_TRUE(changed());
  graph.addExperience(MapPose{});
  EXPECT_TRUE(changed());
  graph.addLink(linkBetween(0, 1));
  EXPECT_TRUE(changed());
  graph.setPoses([](std::uint32_t) { return MapPose{}; });
  EXPECT_TRUE(changed());
  EXPECT_FALSE(changed());
}

}  // namespace
}  // namespace ratslam
