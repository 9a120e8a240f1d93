/// Whether the parts of a map belong together.
#pragma once

#include <string>
#include <vector>

#include "ratslam/common/state.h"
#include "ratslam/system/map_store.h"

namespace ratslam {

/// Why going on in this map would confuse places: the pose cells refer to templates that the local view lacks, or know
/// fewer experiences than the map. This happens when a part restarted without its memory. Empty if the parts agree.
/// Missing parts are not compared.
std::string misfitOf(const State& map);

/// @param name  of the file, for the message
/// @throws std::runtime_error naming the part that is missing: a node's checkpoint holds only one
void requireAllParts(const std::string& name, const State& map);

/// Whether both maps hold the same drive. If one was pruned or continued, their templates begin alike. In a merged map
/// the templates of the second drive come last: then a session that both maps have tells. Two maps of one session each
/// are compared by their templates alone, because stamps of recordings often begin with 0.
bool holdTheSameDrive(const MapCheckpoint& a, const MapCheckpoint& b);

/// All differences between the parts, including those that only prevent a merge.
std::vector<std::string> misfitsOf(const State& map);

}  // namespace ratslam
