/// The release this library was built from, as reports and summaries name it.
#pragma once

#include <string>

namespace ratslam {

/// "MAJOR.MINOR.PATCH" of the package.
std::string version();

}  // namespace ratslam
