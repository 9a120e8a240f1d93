#include "ratslam/vision/image_pyramid.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace ratslam {

ImagePyramid::ImagePyramid(const cv::Mat& grey, int levels, double factor) {
  images_.push_back(grey.clone());
  for (int level = 1; level < levels; ++level) {
    const double scale = std::pow(factor, level);
    const cv::Size size(std::max(1, static_cast<int>(std::lround(grey.cols / scale))),
                        std::max(1, static_cast<int>(std::lround(grey.rows / scale))));
    cv::Mat smaller;
    cv::resize(images_.back(), smaller, size, 0, 0, cv::INTER_LINEAR);
    images_.push_back(smaller);
  }
  for (const cv::Mat& image : images_) {
    ratios_.emplace_back(static_cast<double>(grey.cols) / image.cols,
                         static_cast<double>(grey.rows) / image.rows);
    scales_.push_back(std::sqrt(ratios_.back().x() * ratios_.back().y()));
  }
}

}  // namespace ratslam
