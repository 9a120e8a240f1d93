#include "target.h"

namespace ratslam::fuzz {

std::vector<Target> messageTargets() { return {}; }

}  // namespace ratslam::fuzz
