/// Whether the parts of a map belong together.
#pragma once

#include <string>
#include <vector>

#include "ratslam/common/state.h"

namespace ratslam {

/// Why the parts are not those of one moment: a part names what the part before it does not know, or numbers it gave are
/// missing in the map. Parts that are not there are not compared. Empty if they fit.
std::string misfitOf(const State& map);

/// All that keeps the parts from being one map: the same, and what a merge refuses, which a part that has lost its memory
/// leaves behind.
std::vector<std::string> misfitsOf(const State& map);

}  // namespace ratslam
