/// Parts of a map that were not saved at one moment are told apart from those that were.
#include "ratslam/system/map_fit.h"

#include <gtest/gtest.h>

#include "ratslam/events.h"

namespace ratslam {
namespace {

struct Row {
  std::uint32_t view_id = 0;
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("view_id", view_id);
  }
};

std::vector<Row> rows(std::uint32_t count) {
  std::vector<Row> all(count);
  for (std::uint32_t id = 0; id < count; ++id) all[id].view_id = id;
  return all;
}

/// @param in_map  numbers in the map of the pose cells' numbers; empty if nothing but a run has driven
State mapOf(std::uint32_t templates, std::uint32_t of_pose_cells, std::uint32_t experiences,
            const std::vector<std::uint32_t>& in_map = {}) {
  State map;
  map.child("local_view").set("templates", rows(templates));
  State& cells = map.child("pose_cells").child("cells");
  cells.child("view_input").set("view_links", rows(of_pose_cells));
  cells.child("selector").set("selection", rows(of_pose_cells));
  State& part = map.child("experience_map");
  part.child("map").child("graph").set("experiences", rows(experiences));
  part.set("experience_of", in_map);
  part.set("session", NumberSession{in_map.empty() ? 0 : 5, 0});
  return map;
}

TEST(MapFit, PartsOfOneMomentFit) {
  for (const State& map : {mapOf(4, 3, 3), mapOf(4, 3, 3, {0, 1, 2}), mapOf(0, 0, 0)}) {
    EXPECT_EQ(misfitOf(map), "");
    EXPECT_TRUE(misfitsOf(map).empty());
  }
}

TEST(MapFit, ATemplateThatThereIsNotIsNamed) {
  const State map = mapOf(3, 4, 4);
  EXPECT_NE(misfitOf(map).find("view_links names template 3, but there are 3"), std::string::npos);
  EXPECT_EQ(misfitsOf(map).size(), 2U);
}

TEST(MapFit, PlacesThatOnlyOneKnowsAreCounted) {
  for (const State& map :
       {mapOf(4, 4, 3), mapOf(4, 4, 3, {0, 1, 2}), mapOf(4, 3, 4), mapOf(4, 2, 3, {0, 1, 2})}) {
    ASSERT_EQ(misfitsOf(map).size(), 1U);
    EXPECT_NE(misfitsOf(map)[0].find("do not know the same places: "), std::string::npos);
  }
}

TEST(MapFit, NumbersThatThePoseCellsWouldGiveAgainAreADanger) {
  EXPECT_EQ(misfitOf(mapOf(4, 4, 3, {0, 1, 2})), "") << "a recall of the fourth creates it";
  EXPECT_NE(misfitOf(mapOf(4, 2, 3, {0, 1, 2})).find("do not know the same places: 2 and 3"),
            std::string::npos);
  EXPECT_NE(misfitOf(mapOf(4, 3, 4)), "");
}

TEST(MapFit, AfterALossOfMemoryTheyFitButCannotBeMerged) {
  const State map = mapOf(4, 3, 4, {0, 1, 3});
  EXPECT_EQ(misfitOf(map), "");
  ASSERT_EQ(misfitsOf(map).size(), 2U);
  EXPECT_EQ(
      misfitsOf(map)[0],
      "the pose cells have lost memory while this map was made: what the pose cells call experience 2 is "
      "another one in the map");
  EXPECT_EQ(misfitsOf(mapOf(5, 5, 4, {0, 1, 3}))[0].find("the experience map has lost memory"), 0U);
}

TEST(MapFit, APartAloneIsNotCompared) {
  State part;
  part.child("pose_cells") = mapOf(0, 4, 0).child("pose_cells");
  EXPECT_EQ(misfitOf(part), "");
  EXPECT_TRUE(misfitsOf(part).empty());
}

}  // namespace
}  // namespace ratslam
