#include "map_export.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <ostream>

#include "ratslam/common/parameter_map.h"
#include "ratslam/dataset/trajectory_io.h"
#include "ratslam/experience_map/experience_map.h"
#include "ratslam/experience_map/map_file.h"
#include "ratslam/system/map_fit.h"
#include "ratslam/system/run_log.h"

namespace ratslam {
namespace {

constexpr double kEquator = 6378137.0;              // WGS 84 [m]
constexpr double kEccentricity = 6.69437999014e-3;  // squared

ExperienceGraph graphOf(const MapCheckpoint& map) {
  const State* state = map.state.find("experience_map/map/graph");
  if (state == nullptr) throw std::runtime_error("this file holds no experience map");
  ExperienceGraph graph;
  graph.load(*state);
  return graph;
}

}  // namespace

std::vector<MapCount> countMap(const MapCheckpoint& map) {
  std::vector<MapCount> counts;
  const auto add = [&](const char* name, const char* path) {
    const State* table = map.state.find(path);
    if (table != nullptr) counts.push_back({name, static_cast<std::size_t>(table->rows().value_or(0))});
  };
  add("templates", "local_view/templates");
  add("views tied to pose cells", "pose_cells/cells/view_input/view_links");
  add("experiences of the pose cells", "pose_cells/cells/selector/selection");
  add("experiences", "experience_map/map/graph/experiences");
  add("links", "experience_map/map/graph/links");
  add("pose graph nodes", "experience_map/map/solver/graph/nodes");
  add("pose graph constraints", "experience_map/map/solver/graph/constraints");
  add("trajectory samples", "experience_map/map/trajectory/samples");
  return counts;
}

std::vector<std::string> faultsOf(const MapCheckpoint& map) {
  std::vector<std::string> faults = misfitsOf(map.state);
  try {
    if (map.state.find("experience_map") != nullptr)
      graphOf(map);  // throws if the end of a link does not exist
  } catch (const std::runtime_error& error) {
    faults.emplace_back(error.what());
  }
  return faults;
}

std::vector<std::vector<StampedPose3>> stretchesIn(const MapCheckpoint& map) {
  const State* state = map.state.find("experience_map/map");
  if (state == nullptr) throw std::runtime_error("this file holds no experience map");
  ParameterMap parameters;
  for (const auto& [key, value] : map.parameters) {
    if (key.rfind("exp_", 0) == 0 && key.rfind("exp_delta", 0) != 0)
      parameters.setFromAssignment(key + "=" + value);
  }
  ExperienceMapParams params;
  parameters.read(params);
  ExperienceMap loaded(params);
  loaded.load(*state);
  return stretchesOf(toPoses3(loaded.finalTrajectory()));
}

void exportYaml(std::ostream& out, const MapCheckpoint& map) { writeMap(out, graphOf(map)); }

void exportGraphml(std::ostream& out, const MapCheckpoint& map) {
  const ExperienceGraph graph = graphOf(map);
  out << std::setprecision(std::numeric_limits<double>::max_digits10)
      << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         "<graphml xmlns=\"http://graphml.graphdrawing.org/xmlns\">\n";
  for (const char* name : {"x", "y", "z", "yaw"}) {
    out << "  <key id=\"" << name << "\" for=\"node\" attr.name=\"" << name << "\" attr.type=\"double\"/>\n";
  }
  for (const char* name : {"distance", "heading_rad", "facing_rad", "duration_s"}) {
    out << "  <key id=\"" << name << "\" for=\"edge\" attr.name=\"" << name << "\" attr.type=\"double\"/>\n";
  }
  out << "  <key id=\"recall\" for=\"edge\" attr.name=\"recall\" attr.type=\"boolean\"/>\n"
         "  <graph id=\"experiences\" edgedefault=\"directed\">\n";
  const auto data = [&out](const char* key, const auto& value) {
    out << "<data key=\"" << key << "\">" << value << "</data>";
  };
  for (std::size_t id = 0; id < graph.experiences().size(); ++id) {
    const MapPose& pose = graph.experiences()[id].pose;
    out << "    <node id=\"" << id << "\">";
    data("x", pose.x);
    data("y", pose.y);
    data("z", pose.z);
    data("yaw", pose.yaw);
    out << "</node>\n";
  }
  for (const Link& link : graph.links()) {
    out << "    <edge source=\"" << link.from << "\" target=\"" << link.to << "\">";
    data("distance", link.distance);
    data("heading_rad", link.heading_rad);
    data("facing_rad", link.facing_rad);
    data("duration_s", link.duration_s);
    data("recall", link.recall ? "true" : "false");
    out << "</edge>\n";
  }
  out << "  </graph>\n</graphml>\n";
}

void exportGeojson(std::ostream& out, const MapCheckpoint& map, const MapAnchor& anchor) {
  const ExperienceGraph graph = graphOf(map);
  const double latitude = degreesToRadians(anchor.latitude_deg);
  const double bearing = degreesToRadians(anchor.bearing_deg);
  const double w = std::sqrt(1.0 - kEccentricity * std::sin(latitude) * std::sin(latitude));
  const double north_radius = kEquator * (1.0 - kEccentricity) / (w * w * w);
  const double east_radius = kEquator / w * std::cos(latitude);
  const auto place = [&](std::uint32_t id) {
    const MapPose& pose = graph.pose(id);
    const double north = pose.x * std::cos(bearing) + pose.y * std::sin(bearing);
    const double east = pose.x * std::sin(bearing) - pose.y * std::cos(bearing);
    out << '[' << std::remainder(anchor.longitude_deg + east / east_radius * 180.0 / kPi, 360.0) << ", "
        << anchor.latitude_deg + north / north_radius * 180.0 / kPi << ']';
  };
  out << std::setprecision(12) << "{\"type\": \"FeatureCollection\", \"features\": [";
  const char* separator = "\n";
  for (std::uint32_t id = 0; id < graph.experiences().size(); ++id) {
    out << separator << R"({"type": "Feature", "properties": {"experience": )" << id
        << R"(}, "geometry": {"type": "Point", "coordinates": )";
    place(id);
    out << "}}";
    separator = ",\n";
  }
  for (const Link& link : graph.links()) {
    out << separator << R"({"type": "Feature", "properties": {"recall": )" << (link.recall ? "true" : "false")
        << R"(, "distance": )" << link.distance
        << R"(}, "geometry": {"type": "LineString", "coordinates": [)";
    place(link.from);
    out << ", ";
    place(link.to);
    out << "]}}";
    separator = ",\n";
  }
  out << "\n]}\n";
}

}  // namespace ratslam
