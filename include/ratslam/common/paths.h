/// Paths as users write them.
#pragma once

#include <string>

namespace ratslam {

/// Whether two paths lead to the same place, links followed. What is not there is compared by its name.
bool sameFile(const std::string& a, const std::string& b);

/// The path with the user's home folder in place of "~" at its beginning ("~" or "~/..."). A shell does the same, but
/// not behind "--out=" or "map_dir:=".
std::string withHome(const std::string& path);

}  // namespace ratslam
