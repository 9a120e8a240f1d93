/// Check of file names in requests: files must be inside the folders that the parameters allow.
#pragma once

#include <string>
#include <vector>

namespace ratslam {

/// @param path     relative to the first of `folders`, or absolute
/// @param folders  allowed folders; empty ones do not count
/// @param ending   required ending of the name, such as ".db"; empty: any
/// @return the absolute path
/// @throws std::runtime_error naming the path and the requirement: no folder is allowed, the path leads outside, a part
/// of it is "..", a symbolic link or missing, or it is a folder itself
std::string pathInside(const std::string& path, const std::vector<std::string>& folders,
                       const std::string& ending);

}  // namespace ratslam
