/// Orientation energies as a person can read them: in each cell the edges that stand out from what is usual
/// there, as strokes along them, the brighter the more they do.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace ratslam {

/// @param values kOrientationValues in the order of OrientationEnergy::values. @return 8-bit mono.
cv::Mat orientationPicture(const std::vector<std::int8_t>& values);

}  // namespace ratslam
