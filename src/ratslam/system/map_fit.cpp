#include "ratslam/system/map_fit.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <stdexcept>

#include "ratslam/events.h"

namespace ratslam {
namespace {

std::size_t rowsOf(const State* table) { return table == nullptr ? 0 : table->rows().value_or(0); }

/// Complaints about templates to which the pose cells refer and which the local view lacks.
std::vector<std::string> unknownTemplates(const State& map) {
  std::vector<std::string> faults;
  const State* templates = map.find("local_view/templates");
  if (templates == nullptr) return faults;
  for (const State* table : {map.find("pose_cells/cells/view_input/view_links"),
                             map.find("pose_cells/cells/selector/selection")}) {
    if (rowsOf(table) == 0) continue;
    std::uint32_t largest = 0;
    for (const std::uint32_t number : table->get<std::vector<std::uint32_t>>("view_id")) {
      if (number != std::numeric_limits<std::uint32_t>::max()) largest = std::max(largest, number);
    }
    if (largest < rowsOf(templates)) continue;
    faults.push_back(table->path() + " names template " + std::to_string(largest) + ", but there are " +
                     std::to_string(rowsOf(templates)));
  }
  return faults;
}

/// Numbers of experiences in the pose cells and in the map.
struct Numbers {
  std::size_t of_pose_cells = 0;
  std::size_t of_map = 0;
  std::vector<std::uint32_t> in_map;  ///< for each number of the pose cells; empty if they are the same
  bool counted = false;               ///< whether in_map is kept
  bool comparable = false;

  explicit Numbers(const State& map) {
    const State* cells = map.find("pose_cells/cells/selector/selection");
    const State* part = map.find("experience_map");
    const State* graph = map.find("experience_map/map/graph/experiences");
    comparable = cells != nullptr && graph != nullptr;
    if (!comparable) return;
    of_pose_cells = rowsOf(cells);
    of_map = rowsOf(graph);
    in_map = part->get<std::vector<std::uint32_t>>("experience_of");
    counted = part->get<NumberSession>("session").id != 0;
  }

  /// Numbers of the pose cells that the map knows.
  std::size_t known() const { return counted ? in_map.size() : of_map; }
};

std::string differ(std::size_t pose_cells, std::size_t map) {
  return "pose cells and experience map do not know the same places: " + std::to_string(pose_cells) +
         " and " + std::to_string(map);
}

bool templatesBeginAlike(const State& a, const State& b) {
  const State* of_a = a.find("local_view/templates");
  const State* of_b = b.find("local_view/templates");
  if (rowsOf(of_a) == 0 || rowsOf(of_b) == 0) return false;
  const std::vector<std::uint8_t>& first = of_a->array("values").bytes;
  const std::vector<std::uint8_t>& second = of_b->array("values").bytes;
  const auto count = static_cast<std::ptrdiff_t>(std::min(first.size(), second.size()));
  return count > 0 && std::equal(first.begin(), first.begin() + count, second.begin());
}

bool haveACommonSession(const std::vector<MapSession>& a, const std::vector<MapSession>& b) {
  if (a.size() <= 1 && b.size() <= 1) return false;
  return std::any_of(a.begin(), a.end(), [&b](const MapSession& session) {
    return std::find(b.begin(), b.end(), session) != b.end();
  });
}

}  // namespace

std::string misfitOf(const State& map) {
  const std::vector<std::string> unknown = unknownTemplates(map);
  if (!unknown.empty()) return unknown.front();
  const Numbers numbers(map);
  if (!numbers.comparable || numbers.of_pose_cells >= numbers.known()) return "";
  return differ(numbers.of_pose_cells, numbers.known());
}

std::vector<std::string> misfitsOf(const State& map) {
  std::vector<std::string> faults = unknownTemplates(map);
  const Numbers numbers(map);
  if (!numbers.comparable) return faults;
  for (std::uint32_t id = 0; id < numbers.in_map.size(); ++id) {
    if (numbers.in_map[id] == id) continue;
    // Whoever lost its memory, or a part of it, knows fewer places since.
    const bool map_lost = numbers.of_pose_cells > numbers.of_map;
    faults.push_back(std::string(map_lost ? "the experience map has" : "the pose cells have") +
                     " lost memory while this map was made: what the pose cells call experience " +
                     std::to_string(id) + " is another one in the map");
    break;
  }
  if (numbers.of_pose_cells != numbers.of_map)
    faults.push_back(differ(numbers.of_pose_cells, numbers.of_map));
  return faults;
}

void requireAllParts(const std::string& name, const State& map) {
  for (const char* part : {"local_view", "pose_cells", "experience_map"}) {
    if (!map.hasChild(part)) {
      throw std::runtime_error(name + ": it holds no " + part +
                               "; a checkpoint of a node is one part of a map, SaveMap writes a whole one");
    }
  }
}

bool holdTheSameDrive(const MapCheckpoint& a, const MapCheckpoint& b) {
  return templatesBeginAlike(a.state, b.state) || haveACommonSession(a.sessions, b.sessions);
}

}  // namespace ratslam
