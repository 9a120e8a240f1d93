/// Paths as users write them.
#pragma once

#include <string>

namespace ratslam {

/// Whether two paths lead to the same file or folder, links followed. Paths that do not exist are compared by their
/// normalised names.
bool sameFile(const std::string& a, const std::string& b);

/// The path with the user's home folder in place of "~" at its beginning ("~" or "~/..."). A shell does the same, but
/// not behind "--out=" or "map_dir:=".
std::string withHome(const std::string& path);

}  // namespace ratslam
