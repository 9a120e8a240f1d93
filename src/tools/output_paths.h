// Where a program reads and writes, checked before it writes anything.
#pragma once

#include <string>
#include <vector>

namespace ratslam {

/// A file that an option names; the path is empty if the option is not given.
struct OptionPath {
  std::string option;  ///< such as "--video"
  std::string path;
};

/// Checks that no file is written in the place of one that is read, or of another one that is written.
/// @throws std::invalid_argument naming both
void requireApart(const std::vector<OptionPath>& read, const std::vector<OptionPath>& written);

}  // namespace ratslam
