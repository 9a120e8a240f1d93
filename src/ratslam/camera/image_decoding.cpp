#include "ratslam/camera/image_decoding.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "compressed_header.h"
#include "ratslam/common/text_file.h"

namespace ratslam {
namespace {

constexpr std::uint64_t kMaxSide = 65535;
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 30;
constexpr int kNoConversion = -1;
constexpr bool kHostIsBigEndian = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__;

struct Encoding {
  const char* name;
  int type;        ///< of the pixels in memory
  int conversion;  ///< cv::ColorConversionCodes
};

// ROS names a Bayer pattern by its first two rows, OpenCV by its second row.
const Encoding kEncodings[] = {
    {"mono8", CV_8UC1, kNoConversion},
    {"8UC1", CV_8UC1, kNoConversion},
    {"mono16", CV_16UC1, kNoConversion},
    {"16UC1", CV_16UC1, kNoConversion},
    {"bgr8", CV_8UC3, kNoConversion},
    {"8UC3", CV_8UC3, kNoConversion},
    {"rgb8", CV_8UC3, cv::COLOR_RGB2BGR},
    {"bgra8", CV_8UC4, cv::COLOR_BGRA2BGR},
    {"8UC4", CV_8UC4, cv::COLOR_BGRA2BGR},
    {"rgba8", CV_8UC4, cv::COLOR_RGBA2BGR},
    {"bgr16", CV_16UC3, kNoConversion},
    {"rgb16", CV_16UC3, cv::COLOR_RGB2BGR},
    {"bayer_rggb8", CV_8UC1, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr8", CV_8UC1, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg8", CV_8UC1, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg8", CV_8UC1, cv::COLOR_BayerGB2BGR},
    {"bayer_rggb16", CV_16UC1, cv::COLOR_BayerBG2BGR},
    {"bayer_bggr16", CV_16UC1, cv::COLOR_BayerRG2BGR},
    {"bayer_gbrg16", CV_16UC1, cv::COLOR_BayerGR2BGR},
    {"bayer_grbg16", CV_16UC1, cv::COLOR_BayerGB2BGR},
    {"yuv422", CV_8UC2, cv::COLOR_YUV2GRAY_UYVY},
    {"yuv422_yuy2", CV_8UC2, cv::COLOR_YUV2GRAY_YUY2},
};

const Encoding& encodingOf(const std::string& name) {
  std::string known;
  for (const Encoding& encoding : kEncodings) {
    if (name == encoding.name) return encoding;
    known += (known.empty() ? "" : ", ") + std::string(encoding.name);
  }
  throw BadImage("image encoding '" + shown(name) + "' is not supported: " + known + " are");
}

std::string sizeText(std::uint64_t width, std::uint64_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

void requireAllowedSize(std::uint64_t width, std::uint64_t height, const ImageLimits& limits) {
  if (width == 0 || height == 0) throw BadImage("image without pixels");
  if (width > kMaxSide || height > kMaxSide ||
      width * height > static_cast<std::uint64_t>(limits.max_pixels)) {
    throw BadImage("image of " + sizeText(width, height) + " pixels: at most " +
                   std::to_string(limits.max_pixels) + " (image_max_pixels) and sides of " +
                   std::to_string(kMaxSide) + " are taken");
  }
}

cv::Mat withBytesSwapped(const cv::Mat& image) {
  cv::Mat swapped = image.clone();
  for (int row = 0; row < swapped.rows; ++row) {
    auto* value = swapped.ptr<std::uint16_t>(row);
    for (int i = 0; i < swapped.cols * swapped.channels(); ++i) {
      value[i] = static_cast<std::uint16_t>((value[i] << 8) | (value[i] >> 8));
    }
  }
  return swapped;
}

/// Converts an image to one of the four types of decoded images.
cv::Mat modelImage(cv::Mat image) {
  if (image.channels() == 2) {
    cv::extractChannel(image.clone(), image, 0);
  } else if (image.channels() == 4) {
    cv::cvtColor(image, image, cv::COLOR_BGRA2BGR);
  }
  const int type = image.type();
  if (type != CV_8UC1 && type != CV_8UC3 && type != CV_16UC1 && type != CV_16UC3) {
    throw BadImage("pixels of type " + cv::typeToString(type) +
                   ": grey or colours of 8 or 16 bits are taken");
  }
  return image;
}

std::vector<std::uint8_t> readFile(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (error || status.type() == std::filesystem::file_type::not_found)
    throw BadImage("there is no such file");
  if (!std::filesystem::is_regular_file(status)) throw BadImage("it is no ordinary file");
  const auto bytes = std::filesystem::file_size(path, error);
  if (error || bytes > kMaxFileBytes) throw BadImage("the file is too large for an image");
  std::vector<std::uint8_t> data(static_cast<std::size_t>(bytes));
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(data.data()), static_cast<std::streamsize>(data.size()));
  if (!file) throw BadImage("the file cannot be read");
  return data;
}

}  // namespace

cv::Mat decodeRaw(const RawImage& image, const ImageLimits& limits) {
  const Encoding& encoding = encodingOf(image.encoding);
  requireAllowedSize(image.width, image.height, limits);
  const std::uint64_t row_bytes = std::uint64_t{image.width} * CV_ELEM_SIZE(encoding.type);
  const std::uint64_t needed = std::uint64_t{image.step} * (image.height - 1) + row_bytes;
  const bool whole_numbers = image.step % CV_ELEM_SIZE1(encoding.type) == 0;
  if (image.step < row_bytes || needed > image.size || !whole_numbers) {
    throw BadImage("malformed image: " + sizeText(image.width, image.height) + " pixels of " +
                   image.encoding + " in rows of " + std::to_string(image.step) +
                   (whole_numbers ? " bytes do not fit its " + std::to_string(image.size) + " bytes"
                                  : " bytes, which is no number of whole pixels"));
  }
  const cv::Mat shared(static_cast<int>(image.height), static_cast<int>(image.width), encoding.type,
                       const_cast<std::uint8_t*>(image.data), image.step);
  try {
    const bool swap = CV_MAT_DEPTH(encoding.type) == CV_16U && image.big_endian != kHostIsBigEndian;
    const cv::Mat pixels = swap ? withBytesSwapped(shared) : shared;
    if (encoding.conversion == kNoConversion) return modelImage(pixels.clone());
    cv::Mat converted;
    cv::cvtColor(pixels, converted, encoding.conversion);
    return modelImage(converted);
  } catch (const cv::Exception& e) {
    throw BadImage("malformed image of encoding " + image.encoding + ": " + e.err);
  }
}

cv::Mat decodeCompressed(const std::uint8_t* data, std::size_t size, const ImageLimits& limits) {
  const cv::Size measured = measureCompressed(data, size);
  requireAllowedSize(static_cast<std::uint64_t>(measured.width), static_cast<std::uint64_t>(measured.height),
                     limits);
  requireWholeCompressed(data, size);
  cv::Mat image;
  try {
    const cv::Mat bytes(1, static_cast<int>(size), CV_8UC1, const_cast<std::uint8_t*>(data));
    image = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);  // ignores orientation tags
  } catch (const cv::Exception&) {                      // some decoders throw, others return an empty image
  }
  if (image.size() != measured)
    throw BadImage("corrupt compressed image (" + std::to_string(size) + " bytes)");
  return modelImage(image);
}

cv::Size measureCompressed(const std::uint8_t* data, std::size_t size) {
  const CompressedHeader header = readCompressedHeader(data, size);
  return {static_cast<int>(header.width), static_cast<int>(header.height)};
}

cv::Mat decodeImageFile(const std::string& path, const ImageLimits& limits) {
  const std::vector<std::uint8_t> data = readFile(path);
  return decodeCompressed(data.data(), data.size(), limits);
}

cv::Size measureImageFile(const std::string& path) {
  const std::vector<std::uint8_t> data = readFile(path);
  return measureCompressed(data.data(), data.size());
}

}  // namespace ratslam
