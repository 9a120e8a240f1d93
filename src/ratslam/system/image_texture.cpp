#include "ratslam/system/image_texture.h"

#include <algorithm>

#include "ratslam/camera/grey.h"

namespace ratslam {
namespace {

constexpr int kColumns = 16;
constexpr int kRows = 8;
constexpr double kLeastRange = 0.01;  // range of the block means / range from black to white

/// With this range among a few blocks the image has texture, and the others are not needed.
constexpr double kPlainlyTextured = 0.1;

double rangeOf(const BlockSums& blocks) {
  const auto [least, most] = std::minmax_element(blocks.sums.begin(), blocks.sums.end());
  return static_cast<double>(*most - *least) / static_cast<double>(blocks.full_scale);
}

}  // namespace

bool hasTexture(const cv::Mat& image) {
  const int columns = std::min(kColumns, image.cols);
  const int rows = std::min(kRows, image.rows);
  const int strip = image.rows / rows;
  for (const int row : {rows / 2, rows - 1}) {
    if (rangeOf(sumBlocks(image, cv::Rect(0, row * strip, image.cols, strip), columns, 1)) > kPlainlyTextured)
      return true;
  }
  return rangeOf(sumBlocks(image, cv::Rect(0, 0, image.cols, image.rows), columns, rows)) > kLeastRange;
}

}  // namespace ratslam
