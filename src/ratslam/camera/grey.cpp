#include "ratslam/camera/grey.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <sstream>
#include <stdexcept>

namespace ratslam {
namespace {

constexpr int kMaxSide = 65535;  // so that a column of 16-bit pixels sums to less than 2^32

/// Adds the colours of each pixel of a row to the sum of its column.
template <class Value, int channels, int colours>
void addRow(const cv::Mat& image, int y, int x, std::vector<std::uint32_t>& column_sums) {
  const Value* pixel = image.ptr<Value>(y) + static_cast<std::ptrdiff_t>(x) * channels;
  std::uint32_t* sums = column_sums.data();
  const std::size_t width = column_sums.size();
  for (std::size_t i = 0; i < width; ++i) {
    std::uint32_t sum = 0;
    for (std::size_t c = 0; c < colours; ++c) sum += pixel[i * channels + c];
    sums[i] += sum;
  }
}

using AddRow = void (*)(const cv::Mat&, int, int, std::vector<std::uint32_t>&);

AddRow addRowFor(const cv::Mat& image) {
  switch (image.type()) {
    case CV_8UC3:
      return addRow<std::uint8_t, 3, 3>;
    case CV_8UC4:
      return addRow<std::uint8_t, 4, 3>;
    case CV_16UC1:
      return addRow<std::uint16_t, 1, 1>;
    default:
      return addRow<std::uint8_t, 1, 1>;
  }
}

}  // namespace

PixelFormat pixelFormat(const cv::Mat& image) {
  if (image.empty()) throw std::invalid_argument("image: it is empty");
  if (image.dims != 2 || image.cols > kMaxSide || image.rows > kMaxSide) {
    throw std::invalid_argument("image: it must have two dimensions of at most 65535 pixels each");
  }
  switch (image.type()) {
    case CV_8UC1:
      return {1, 1, 255};
    case CV_8UC3:
      return {3, 3, 255};
    case CV_8UC4:
      return {4, 3, 255};
    case CV_16UC1:
      return {1, 1, 65535};
    default:
      break;
  }
  std::ostringstream message;
  message << "image: unsupported type " << cv::typeToString(image.type())
          << ", it must be CV_8UC1, CV_8UC3, CV_8UC4 or CV_16UC1";
  throw std::invalid_argument(message.str());
}

cv::Mat eightBitGrey(const cv::Mat& image) {
  const PixelFormat format = pixelFormat(image);
  if (image.type() == CV_8UC1) return image;
  cv::Mat grey;
  if (format.channels == 1) {
    image.convertTo(grey, CV_8U, 255.0 / format.max_value);
  } else {
    cv::cvtColor(image, grey, format.channels == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  }
  return grey;
}

BlockSums sumBlocks(const cv::Mat& image, const cv::Rect& region, int columns, int rows) {
  const PixelFormat format = pixelFormat(image);
  const cv::Rect whole(0, 0, image.cols, image.rows);
  if ((region & whole) != region || columns < 1 || rows < 1 || region.width < columns ||
      region.height < rows) {
    std::ostringstream message;
    message << "image: a region of " << region.width << " x " << region.height << " pixels at (" << region.x
            << ", " << region.y << ") in an image of " << image.cols << " x " << image.rows
            << " cannot be divided into " << columns << " x " << rows << " blocks";
    throw std::invalid_argument(message.str());
  }
  const int block_width = region.width / columns;
  const int block_height = region.height / rows;

  BlockSums blocks;
  blocks.columns = columns;
  blocks.rows = rows;
  blocks.full_scale = static_cast<std::uint64_t>(block_width) * static_cast<std::uint64_t>(block_height) *
                      static_cast<std::uint64_t>(format.colours) * format.max_value;
  blocks.sums.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));

  const AddRow add_row = addRowFor(image);
  std::vector<std::uint32_t> column_sums(static_cast<std::size_t>(block_width) *
                                         static_cast<std::size_t>(columns));
  for (int row = 0; row < rows; ++row) {
    std::fill(column_sums.begin(), column_sums.end(), 0U);
    for (int y = 0; y < block_height; ++y) {
      add_row(image, region.y + row * block_height + y, region.x, column_sums);
    }
    for (auto first = column_sums.begin(); first != column_sums.end(); first += block_width) {
      std::uint64_t sum = 0;
      for (auto it = first; it != first + block_width; ++it) sum += *it;
      blocks.sums.push_back(sum);
    }
  }
  return blocks;
}

}  // namespace ratslam
