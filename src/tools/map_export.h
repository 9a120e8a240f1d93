// Description, check and export of a map file's content.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "ratslam/dataset/trajectory_io.h"
#include "ratslam/system/map_store.h"

namespace ratslam {

struct MapCount {
  std::string name;
  std::size_t number = 0;
};

/// Numbers of templates, experiences, links, ... of the parts that the file holds.
std::vector<MapCount> countMap(const MapCheckpoint& map);

/// Contradictions between the parts of a map, one line each.
std::vector<std::string> faultsOf(const MapCheckpoint& map);

/// Position of the map's origin on the Earth, and direction of its x axis.
struct MapAnchor {
  double latitude_deg = 0.0;
  double longitude_deg = 0.0;
  double bearing_deg = 0.0;  ///< of the x axis, clockwise from north
};

// @throws std::runtime_error if the file holds no experience map
/// The path in the present map. A new stretch begins where time went back, as on another day's drive whose clock began anew.
std::vector<std::vector<StampedPose3>> stretchesIn(const MapCheckpoint& map);
void exportYaml(std::ostream& out, const MapCheckpoint& map);  ///< map.yaml
void exportGraphml(std::ostream& out, const MapCheckpoint& map);
/// Experiences as points, links as lines, in WGS 84. The projection is flat about the anchor: exact to a metre within a
/// few km.
void exportGeojson(std::ostream& out, const MapCheckpoint& map, const MapAnchor& anchor);

}  // namespace ratslam
