/// Images in a State: pixels of any type, row by row.
#pragma once

#include <opencv2/core.hpp>

#include "ratslam/common/state.h"

namespace ratslam {

void setImage(State& state, const cv::Mat& image);

/// @return an image of its own. @throws std::runtime_error where the pixels do not make one
cv::Mat getImage(const State& state);

}  // namespace ratslam
