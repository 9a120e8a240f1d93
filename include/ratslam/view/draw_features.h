/// Picture of the ORB odometry: features of the image and tracked landmarks.
#pragma once

#include <opencv2/core.hpp>

#include "ratslam/vision/frame.h"

namespace ratslam {

/// Draws features as small dots, and tracked landmarks as circles of the size of their pyramid level.
/// @param image 8 or 16 bits, 1, 3 or 4 channels. @throws std::invalid_argument for an image of another kind
cv::Mat drawFeatures(const cv::Mat& image, const Frame& frame, const CameraModel& camera);

}  // namespace ratslam
