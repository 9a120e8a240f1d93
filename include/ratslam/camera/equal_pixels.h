/// Detection of a frozen camera. Noise makes two images of a working camera differ, so equal pixels mean that it has
/// stopped.
#pragma once

#include <opencv2/core.hpp>

namespace ratslam {

/// Whether two images have the same type, size and pixels. Either may have any row stride.
bool equalPixels(const cv::Mat& a, const cv::Mat& b);

}  // namespace ratslam
