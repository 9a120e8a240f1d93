/// Decoding of images from drivers, bags and folders.
///
/// The result is CV_8UC1, CV_8UC3 (BGR), CV_16UC1 or CV_16UC3, in its own memory. ImageStage converts colours of 16
/// bits to 8 bits for the models, once it has found how many of the 16 bits are used. Alpha is dropped, a Bayer mosaic
/// is converted to colours, and only the luminance of YUV is kept. Orientation tags (EXIF) are ignored in files and in
/// messages. Sizes are checked in 64 bits before memory is allocated. Only OpenCV's decoders for JPEG and PNG are
/// called.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

namespace ratslam {

/// Thrown for bytes that hold no usable image; the message is the reason.
class BadImage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct ImageLimits {
  std::int64_t max_pixels = 50000000;  ///< a larger image is refused before it is decoded
};

/// Pixels in the form of a message, row by row.
struct RawImage {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::uint32_t step = 0;  ///< bytes from one row to the next
  std::string encoding;    ///< a name of sensor_msgs/image_encodings.h
  bool big_endian = false;
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;  ///< [bytes]
};

/// Takes mono8, mono16, 8UC1, 16UC1, 8UC3, 8UC4, bgr8, rgb8, bgra8, rgba8, bgr16, rgb16, bayer_*, yuv422 and
/// yuv422_yuy2. @throws BadImage for any other encoding, and for sizes that contradict the data
cv::Mat decodeRaw(const RawImage& image, const ImageLimits& limits = {});

/// Decodes a JPEG or PNG, recognised by its first bytes. @throws BadImage for other, corrupt or truncated data
cv::Mat decodeCompressed(const std::uint8_t* data, std::size_t size, const ImageLimits& limits = {});

/// The same of a file. @throws BadImage also for a file that cannot be read
cv::Mat decodeImageFile(const std::string& path, const ImageLimits& limits = {});

/// Width and height from the header of a JPEG or PNG. @throws BadImage if it has none
cv::Size measureCompressed(const std::uint8_t* data, std::size_t size);
cv::Size measureImageFile(const std::string& path);

}  // namespace ratslam
