/// Picture of orientation energies: in each cell strokes along the edges that are stronger than usual there. Brighter
/// strokes are stronger.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace ratslam {

/// @param values kOrientationValues in the order of OrientationEnergy::values. @return 8-bit mono.
cv::Mat orientationPicture(const std::vector<std::int8_t>& values);

}  // namespace ratslam
