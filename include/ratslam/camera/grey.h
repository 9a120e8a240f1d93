/// Grey values of an image as sums over blocks of pixels (docs/model.md section 1, steps 1-2).
///
/// Grey is the mean of the colour channels; black is 0 and white is 1. The sums are integers, computed directly from
/// the image: they are exact and need no grey copy. Each mean is one division.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

namespace ratslam {

/// Layout of the pixels of an image.
struct PixelFormat {
  int channels = 1;               ///< stored values per pixel
  int colours = 1;                ///< number of leading channels that are colours (alpha is none)
  std::uint32_t max_value = 255;  ///< of one channel
};

/// @throws std::invalid_argument "image: ..." for an empty image, a side above 65535 pixels, or a type other
/// than 8-bit mono, BGR, RGB, BGRA, RGBA (their order does not matter to the mean) and 16-bit mono.
PixelFormat pixelFormat(const cv::Mat& image);

/// Luminance in 8 bits, for corners and patches. 16 bits are scaled to 8 (value / 257, rounded). Colours are in the order blue,
/// green, red (ITU-R BT.601). A grey 8-bit image is returned without a copy: the memory is shared.
/// @throws std::invalid_argument as pixelFormat does
cv::Mat eightBitGrey(const cv::Mat& image);

/// Sums of grey over a grid of equal blocks.
struct BlockSums {
  int columns = 0;
  int rows = 0;
  /// rows x columns, row by row; each over all pixels and colours of a block.
  std::vector<std::uint64_t> sums;
  std::uint64_t full_scale = 1;  ///< sum of a white block: grey mean = sum / full_scale
};

/// Divides `region` into `columns` x `rows` blocks of floor(width / columns) x floor(height / rows) pixels; a
/// remainder at the right and bottom is unused. The image may have any row stride.
/// @throws std::invalid_argument as pixelFormat does, and if the region leaves the image or is smaller than the
/// grid.
BlockSums sumBlocks(const cv::Mat& image, const cv::Rect& region, int columns, int rows);

}  // namespace ratslam
