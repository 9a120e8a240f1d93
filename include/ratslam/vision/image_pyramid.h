/// Image pyramid: the same grey image at coarser and coarser scales.
///
/// Level l has 1/factor^l of the size of level 0, rounded to whole pixels. Pixel centres are at whole coordinates
/// on every level. So the mapping between levels is exact to a fraction of a pixel.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace ratslam {

class ImagePyramid {
 public:
  ImagePyramid() = default;
  /// @param grey 8-bit, one channel; is copied. @param levels at least 1. @param factor > 1.
  ImagePyramid(const cv::Mat& grey, int levels, double factor);

  int levels() const { return static_cast<int>(images_.size()); }
  const cv::Mat& image(int level) const { return images_[static_cast<std::size_t>(level)]; }
  /// Edge of one pixel of `level` [px of level 0].
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
  std::vector<Eigen::Vector2d> ratios_;  // of columns and of rows, which differ slightly by rounding
};

}  // namespace ratslam
