/// Release of this library, for reports and summaries.
#pragma once

#include <string>

namespace ratslam {

/// "MAJOR.MINOR.PATCH" of the package.
std::string version();

}  // namespace ratslam
