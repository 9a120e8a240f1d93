/// The experience graph as a file, map.yaml: plain YAML with one line for each experience and link.
///
///     format: ratslam_experience_map 1
///     experiences:
///     - {id: 0, x: 0, y: 0, z: 0, yaw: 1.5707963267948966, log_scale: 0}
///     links:
///     - {id: 0, from: 0, to: 1, distance: 1, heading_rad: 0, facing_rad: 0, rise: 0, duration_s: 0.1,
///     recall: false}
///
/// Lengths are in metres, angles in radians, distance and rise of links in the odometry's unit. Numbers have 17
/// digits: readMap() returns exactly the graph that was written.
#pragma once

#include <iosfwd>

#include "ratslam/experience_map/experience_graph.h"

namespace ratslam {

void writeMap(std::ostream& out, const ExperienceGraph& graph);

/// @throws std::runtime_error naming the line and what is wrong with it.
ExperienceGraph readMap(std::istream& in);

}  // namespace ratslam
