/// Blank images: in darkness, glare or with a covered lens an image is uniform but for the sensor's noise.
#pragma once

#include <opencv2/core.hpp>

namespace ratslam {

/// False if the means of 16 x 8 blocks lie within 1 % of the range from black to white: noise averages out
/// in a block, a scene does not.
/// @param image CV_8UC1, CV_8UC3 or CV_16UC1
bool hasTexture(const cv::Mat& image);

}  // namespace ratslam
