/// Image pyramid: the same grey image at ever coarser scales.
///
/// Level l has 1/factor^l of the size of level 0, rounded to whole pixels. Coordinates at a level are mapped
/// with pixel centres at whole numbers, so that a point keeps its place to a fraction of a pixel at each
/// level.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace ratslam {

class ImagePyramid {
 public:
  ImagePyramid() = default;
  /// @param grey 8-bit, one channel; it is copied. @param levels at least 1. @param factor > 1.
  ImagePyramid(const cv::Mat& grey, int levels, double factor);

  int levels() const { return static_cast<int>(images_.size()); }
  const cv::Mat& image(int level) const { return images_[static_cast<std::size_t>(level)]; }
  /// Pixels of level 0 along the edge of one pixel of `level`.
  double scale(int level) const { return scales_[static_cast<std::size_t>(level)]; }
  Eigen::Vector2d toLevel(const Eigen::Vector2d& point, int level) const {
    return (point + kHalf).cwiseQuotient(ratios_[static_cast<std::size_t>(level)]) - kHalf;
  }
  Eigen::Vector2d fromLevel(const Eigen::Vector2d& point, int level) const {
    return (point + kHalf).cwiseProduct(ratios_[static_cast<std::size_t>(level)]) - kHalf;
  }

 private:
  inline static const Eigen::Vector2d kHalf{0.5, 0.5};
  std::vector<cv::Mat> images_;
  std::vector<double> scales_;
  std::vector<Eigen::Vector2d> ratios_;  // columns and rows: rounding makes them differ slightly
};

}  // namespace ratslam
