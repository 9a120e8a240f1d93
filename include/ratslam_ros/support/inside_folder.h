/// Files that a request may name: inside the folders that the parameters allow, and nowhere else.
#pragma once

#include <string>
#include <vector>

namespace ratslam {

/// @param path     relative to the first of `folders`, or absolute
/// @param folders  empty ones do not count
/// @param ending   that the name must have, such as ".db"; empty: any
/// @return the absolute path
/// @throws std::runtime_error naming the path and what would be right: no folder is allowed, it leads outside, a
/// part of it is "..", a symbolic link or missing, it is a folder itself
std::string pathInside(const std::string& path, const std::vector<std::string>& folders,
                       const std::string& ending);

}  // namespace ratslam
