#include "ratslam/odometry/orb/image_sight.h"

#include <cstring>
#include <opencv2/imgproc.hpp>

namespace ratslam {
namespace {

constexpr int kCoarseness = 8;          // [px]: averaging takes the sensor's noise out
constexpr double kLeastContrast = 1.5;  // standard deviation of the averaged image [grey levels]

bool sameImage(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size()) return false;
  for (int row = 0; row < a.rows; ++row) {
    if (std::memcmp(a.ptr(row), b.ptr(row), static_cast<std::size_t>(a.cols)) != 0) return false;
  }
  return true;
}

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
  if (sameImage(grey, last_)) return isBlank(grey) ? Sight::kBlank : Sight::kFrozen;
  last_ = grey.clone();
  return isBlank(grey) ? Sight::kBlank : Sight::kClear;
}

}  // namespace ratslam
