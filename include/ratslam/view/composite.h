/// The whole system in one picture, as topics show its parts and a video shows all of it: local view at the
/// upper left, pose cells below it, the map at the right.
#pragma once

#include <opencv2/core.hpp>

namespace ratslam {

constexpr int kCompositeWidth = 1280;
constexpr int kCompositeHeight = 720;

/// Sizes that the parts are best drawn in.
cv::Size localViewPictureSize();
cv::Size activityPictureSize();
cv::Size mapPictureSize();

/// kCompositeWidth x kCompositeHeight, 8-bit BGR. An empty part is left out; one of another size is fitted
/// in.
cv::Mat composite(const cv::Mat& local_view, const cv::Mat& activity, const cv::Mat& map);

}  // namespace ratslam
