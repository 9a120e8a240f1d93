#include "ratslam/experience_map/map_file.h"

#include <gtest/gtest.h>

#include <sstream>

#include "oracle/experience_map_drive.h"

namespace ratslam {
namespace {

std::string written(const ExperienceGraph& graph) {
  std::ostringstream out;
  writeMap(out, graph);
  return out.str();
}

ExperienceGraph mapOfDrive() {
  CityDrive city;
  city.experiences = 200;
  city.blocks = 1;
  city.recall_share = 0.5;
  city.length_noise = 0.05;
  city.yaw_noise = 0.01;
  ExperienceMapParams params;
  params.exp_scale = true;
  ExperienceMap map(params);
  run(map, simulate(city));
  map.settle();
  return map.graph();
}

TEST(MapFile, ReadsBackWhatWasWritten) {
  const ExperienceGraph graph = mapOfDrive();
  ASSERT_GT(graph.links().size(), graph.experiences().size());
  std::istringstream in(written(graph));
  const ExperienceGraph back = readMap(in);
  ASSERT_EQ(back.experiences().size(), graph.experiences().size());
  ASSERT_EQ(back.links().size(), graph.links().size());
  for (std::uint32_t id = 0; id < graph.experiences().size(); ++id) {
    EXPECT_EQ(back.pose(id).x, graph.pose(id).x);
    EXPECT_EQ(back.pose(id).yaw, graph.pose(id).yaw);
    EXPECT_EQ(back.pose(id).log_scale, graph.pose(id).log_scale);
  }
  for (const Link& link : graph.links()) EXPECT_TRUE(back.linked(link.from, link.to));
  EXPECT_EQ(written(back), written(graph));
}

TEST(MapFile, AnEmptyMapIsAMap) {
  std::istringstream in(written(ExperienceGraph{}));
  EXPECT_TRUE(readMap(in).experiences().empty());
}

std::string refusal(const std::string& text) {
  std::istringstream in(text);
  try {
    readMap(in);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(MapFile, SaysWhereAFileIsBroken) {
  const std::string head = "format: ratslam_experience_map 1\nexperiences:\n";
  const std::string first = "- {id: 0, x: 0, y: 0, z: 0, yaw: 0, log_scale: 0}\n";
  const std::string second = "- {id: 1, x: 1, y: 0, z: 0, yaw: 0, log_scale: 0}\n";
  const auto link = [](const std::string& to, const std::string& recall) {
    return "- {id: 0, from: 0, to: " + to +
           ", distance: 1, heading_rad: 0, facing_rad: 0, rise: 0, duration_s: 1, recall: " + recall + "}\n";
  };
  EXPECT_EQ(refusal(head + first + second + "links:\n" + link("1", "false")), "");
  EXPECT_EQ(refusal(""), "map file, line 1: expected \"format: ratslam_experience_map 1\"");
  EXPECT_EQ(refusal(head + first), "map file, line 4: expected \"links:\"");
  EXPECT_EQ(refusal(head + second + "links:\n"), "map file, line 3: experiences must be numbered from 0");
  EXPECT_EQ(refusal(head + "- {id: 0, x: nan, y: 0, z: 0, yaw: 0, log_scale: 0}\nlinks:\n"),
            "map file, line 3: x: nan is not a finite number");
  EXPECT_EQ(refusal(head + "- {id: 0, x: 0, y: 0\n"), "map file, line 3: y: the record is cut off");
  EXPECT_EQ(refusal(head + first + second + "links:\n" + link("2", "false")),
            "map file, line 6: the link must join two of the 2 experiences");
  EXPECT_EQ(refusal(head + first + second + "links:\n" + link("1", "maybe")),
            "map file, line 6: recall: it must be true or false");
}

}  // namespace
}  // namespace ratslam
