/// The whole system in one picture for videos: local view at the upper left, pose cells below it, the map at the right.
#pragma once

#include <opencv2/core.hpp>

namespace ratslam {

constexpr int kCompositeWidth = 1280;
constexpr int kCompositeHeight = 720;

/// Sizes of the parts.
cv::Size localViewPictureSize();
cv::Size activityPictureSize();
cv::Size mapPictureSize();

/// kCompositeWidth x kCompositeHeight, 8-bit BGR. An empty part is left out. A part of another size is scaled.
cv::Mat composite(const cv::Mat& local_view, const cv::Mat& activity, const cv::Mat& map);

}  // namespace ratslam
