/// Detection of a frozen camera: only a camera that hangs gives exactly the same image again.
#pragma once

#include <opencv2/core.hpp>

namespace ratslam {

/// Whether two images have the same type, size and pixels. Either may have any row stride.
bool equalPixels(const cv::Mat& a, const cv::Mat& b);

}  // namespace ratslam
