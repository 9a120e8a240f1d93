#include "ratslam/odometry/orb/image_sight.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "ratslam/camera/equal_pixels.h"

namespace ratslam {
namespace {

constexpr int kCoarseness = 8;          // [px]: averaging takes the sensor's noise out
constexpr double kLeastContrast = 1.5;  // standard deviation of the averaged image [grey levels]

bool isBlank(const cv::Mat& grey) {
  cv::Mat coarse;
  cv::resize(grey, coarse, {std::max(1, grey.cols / kCoarseness), std::max(1, grey.rows / kCoarseness)}, 0.0,
             0.0, cv::INTER_AREA);
  cv::Scalar mean;
  cv::Scalar deviation;
  cv::meanStdDev(coarse, mean, deviation);
  return deviation[0] < kLeastContrast;
}

}  // namespace

Sight ImageSight::look(const cv::Mat& grey) {
  if (equalPixels(grey, last_)) return isBlank(grey) ? Sight::kBlank : Sight::kFrozen;
  last_ = grey.clone();
  return isBlank(grey) ? Sight::kBlank : Sight::kClear;
}

}  // namespace ratslam
