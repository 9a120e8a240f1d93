/// Grey values of an image, taken as sums over blocks of pixels (docs/model.md section 1, steps 1-2).
///
/// Grey is the mean of the colour channels, on a scale where black is 0 and white is 1. Sums of pixels are
/// kept as integers, straight from the image: they are exact, need no grey copy, and every mean derived from
/// them is one division.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace ratslam {

/// How the pixels of an image are laid out.
struct PixelFormat {
  int channels = 1;               ///< stored values a pixel
  int colours = 1;                ///< of these the leading ones that carry light (alpha does not)
  std::uint32_t max_value = 255;  ///< of one channel
};

/// @throws std::invalid_argument "image: ..." for an empty image, a side above 65535 pixels, or a type other
/// than 8-bit mono, BGR, RGB, BGRA, RGBA (their order does not matter to the mean) and 16-bit mono.
PixelFormat pixelFormat(const cv::Mat& image);

/// Luminance in 8 bits, for all that looks at corners and patches; of 16 bits the upper ones, colours as
/// blue, green, red (ITU-R BT.601). A grey image of 8 bits is returned as it is, its memory shared.
/// @throws std::invalid_argument as pixelFormat does
cv::Mat eightBitGrey(const cv::Mat& image);

/// Sums of grey over a grid of equal blocks.
struct BlockSums {
  int columns = 0;
  int rows = 0;
  std::vector<std::uint64_t>
      sums;                      ///< rows x columns, row by row; each over all pixels and colours of a block
  std::uint64_t full_scale = 1;  ///< what a white block sums to: grey mean = sum / full_scale
};

/// Divides `region` into `columns` x `rows` blocks of floor(width / columns) x floor(height / rows) pixels; a
/// remainder at the right and bottom is unused. The image may have any row stride.
/// @throws std::invalid_argument as pixelFormat does, and where the region leaves the image or is smaller
/// than the grid.
BlockSums sumBlocks(const cv::Mat& image, const cv::Rect& region, int columns, int rows);

}  // namespace ratslam
