// What is in a map file, for people and for other programs.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "ratslam/system/map_store.h"

namespace ratslam {

struct MapCount {
  std::string name;
  std::size_t number = 0;
};

/// Templates, experiences, links, ...; those of the parts that the file holds.
std::vector<MapCount> countMap(const MapCheckpoint& map);

/// What does not fit together between the parts of a map, one line each.
std::vector<std::string> faultsOf(const MapCheckpoint& map);

/// Where on the Earth the map's origin lies, and which way its x axis points.
struct MapAnchor {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double bearing_deg = 0.0;  ///< of the x axis, clockwise from north
};

// @throws std::runtime_error where the file holds no experience map
void exportTum(std::ostream& out, const MapCheckpoint& map);   ///< the path as the map sees it
void exportYaml(std::ostream& out, const MapCheckpoint& map);  ///< map.yaml
void exportGraphml(std::ostream& out, const MapCheckpoint& map);
/// Experiences as points, links as lines, in WGS 84. Flat about the anchor: good to a metre within a few km.
void exportGeojson(std::ostream& out, const MapCheckpoint& map, const MapAnchor& anchor);

}  // namespace ratslam
