/// Whether a camera has given the same image again: what a camera that hangs does, and a living one never.
#pragma once

#include <opencv2/core.hpp>

namespace ratslam {

/// Whether two images have the same type, size and pixels. Either may have any row stride.
bool equalPixels(const cv::Mat& a, const cv::Mat& b);

}  // namespace ratslam
