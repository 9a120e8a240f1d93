/// Images in a State: pixels of any type, row by row, or packed.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ratslam/common/state.h"

namespace ratslam {

/// The pixels as they are.
void setImage(State& state, const cv::Mat& image);

/// The same for a photograph, which is packed when somebody looks at it.
/// @param image  8 or 16 bits, 1, 3 or 4 channels, or empty; must not change any more
void setPhoto(State& state, const std::string& name, const cv::Mat& image);

/// @return an image of its own. @throws std::runtime_error where the pixels do not make one
cv::Mat getImage(const State& state);

/// A photograph as PNG, which loses nothing. @throws std::runtime_error where PNG cannot hold the pixels
std::vector<std::uint8_t> packedPhoto(const cv::Mat& image);

}  // namespace ratslam
