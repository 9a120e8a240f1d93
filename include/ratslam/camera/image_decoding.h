/// From bytes to pixels, whatever a driver, bag or folder made of them.
///
/// Pixels come out as the models take them: CV_8UC1, CV_8UC3 (BGR) or CV_16UC1, in memory of their own. Alpha
/// is dropped, a Bayer mosaic becomes colours, of YUV the luminance stays. A tag that asks for the picture to
/// be turned (EXIF) is not obeyed, in files no more than in messages. Everything is measured before memory is
/// taken for it, in 64 bits, and of OpenCV's decoders only those for JPEG and PNG are ever called.
#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

namespace ratslam {

/// Bytes that hold no usable image; says why.
class BadImage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct ImageLimits {
  std::int64_t max_pixels = 50000000;  ///< an image of more is refused before it is decoded
};

/// Pixels as a message carries them, row after row.
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
/// yuv422_yuy2. @throws BadImage for an encoding that is none of these, and for sizes that contradict the data
cv::Mat decodeRaw(const RawImage& image, const ImageLimits& limits = {});

/// A whole JPEG or PNG, told by its first bytes. @throws BadImage for other, corrupt or truncated data
cv::Mat decodeCompressed(const std::uint8_t* data, std::size_t size, const ImageLimits& limits = {});

/// The same of a file. @throws BadImage also for a file that cannot be read
cv::Mat decodeImageFile(const std::string& path, const ImageLimits& limits = {});

/// Width and height of a JPEG or PNG as its header tells them. @throws BadImage where it has none
cv::Size measureCompressed(const std::uint8_t* data, std::size_t size);
cv::Size measureImageFile(const std::string& path);

}  // namespace ratslam
