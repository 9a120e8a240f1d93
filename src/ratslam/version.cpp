#include "ratslam/version.h"

namespace ratslam {

std::string version() { return RATSLAM_VERSION; }

}  // namespace ratslam
