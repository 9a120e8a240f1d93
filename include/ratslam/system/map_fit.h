/// Whether the parts of a map belong together.
#pragma once

#include <string>
#include <vector>

#include "ratslam/common/state.h"

namespace ratslam {

/// Why going on in this map would confuse places: the pose cells refer to templates that the local view lacks, or know
/// fewer experiences than the map. This happens when a part restarted without its memory. Empty if the parts agree.
/// Missing parts are not compared.
std::string misfitOf(const State& map);

/// @param name  of the file, for the message
/// @throws std::runtime_error naming the part that is missing: a node's checkpoint holds only one
void requireAllParts(const std::string& name, const State& map);

/// Whether one map holds the drive of the other one: it was pruned, or continued. Its templates then begin alike.
bool holdTheSameDrive(const State& a, const State& b);

/// All differences between the parts, including those that only prevent a merge.
std::vector<std::string> misfitsOf(const State& map);

}  // namespace ratslam
