/// Images in a State: pixels of any type, row by row, or packed.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ratslam/common/state.h"

namespace ratslam {

/// Stores the pixels unpacked.
void setImage(State& state, const cv::Mat& image);

/// Stores a photograph, which is packed when the State is read.
/// @param image  8 or 16 bits, 1, 3 or 4 channels, or empty; must not change afterwards
void setPhoto(State& state, const std::string& name, const cv::Mat& image);

/// @return a copy. @throws std::runtime_error if the State holds no image
cv::Mat getImage(const State& state);

/// A photograph as PNG, without loss. @throws std::runtime_error if PNG cannot hold the pixels
std::vector<std::uint8_t> packedPhoto(const cv::Mat& image);

}  // namespace ratslam
