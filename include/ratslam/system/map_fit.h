/// Whether the parts of a map belong together.
#pragma once

#include <string>
#include <vector>

#include "ratslam/common/state.h"

namespace ratslam {

/// Why a program that goes on in the map would mistake a view or a place for another one: the pose cells name views that
/// the local view has yet to learn, or have yet to give numbers that the map knows. A part that has lost its memory leaves
/// this behind, until it is heard again. Empty if there is no reason. Parts that are not there are not compared.
std::string misfitOf(const State& map);

/// @param name  of the file, for the message
/// @throws std::runtime_error naming the part that is missing: a node's checkpoint holds only one
void requireAllParts(const std::string& name, const State& map);

/// Everything in which the parts differ: also what is no danger for a program that goes on, but refused by a merge.
std::vector<std::string> misfitsOf(const State& map);

}  // namespace ratslam
