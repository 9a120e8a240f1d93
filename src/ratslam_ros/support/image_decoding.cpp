#include "ratslam_ros/support/image_decoding.h"

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

namespace ratslam {
namespace {

namespace encodings = sensor_msgs::image_encodings;

/// Encoding to convert to, empty for "as it is"; nothing where the encoding is not supported.
std::optional<std::string> targetEncoding(const std::string& encoding) {
  for (const char* mono : {"mono8", "mono16"}) {
    if (encoding == mono) return "";
  }
  for (const char* colour : {"bgr8", "rgb8", "bgra8", "rgba8"}) {
    if (encoding == colour) return encodings::BGR8;
  }
  if (encodings::isBayer(encoding)) return encodings::BGR8;
  return std::nullopt;
}

/// A JPEG ends with the marker FF D9, which cannot occur within its entropy-coded data. Decoders fill up what
/// a truncated file lacks with grey and report success.
bool isTruncatedJpeg(const std::vector<std::uint8_t>& data) {
  const bool is_jpeg = data.size() > 2 && data[0] == 0xFF && data[1] == 0xD8;
  if (!is_jpeg) return false;
  const std::array<std::uint8_t, 2> end_of_image{0xFF, 0xD9};
  return std::find_end(data.begin(), data.end(), end_of_image.begin(), end_of_image.end()) == data.end();
}

}  // namespace

cv::Mat decodeImage(const sensor_msgs::ImageConstPtr& message) {
  const std::optional<std::string> target = targetEncoding(message->encoding);
  if (!target) {
    throw BadImage("image encoding '" + message->encoding +
                   "' is not supported: mono8, mono16, bgr8, rgb8, bgra8, rgba8 and bayer_* are");
  }
  if (message->width == 0 || message->height == 0) throw BadImage("image without pixels");
  try {
    return cv_bridge::toCvShare(message, *target)->image;
  } catch (const std::exception& e) {
    throw BadImage(std::string("malformed image: ") + e.what());
  }
}

cv::Mat decodeImage(const sensor_msgs::CompressedImageConstPtr& message) {
  cv::Mat image;
  if (!message->data.empty() && !isTruncatedJpeg(message->data)) {
    try {
      image = cv::imdecode(message->data, cv::IMREAD_UNCHANGED);
    } catch (const cv::Exception&) {  // some decoders throw where others return nothing
    }
  }
  if (image.empty()) {
    throw BadImage("corrupt compressed image (format '" + message->format + "', " +
                   std::to_string(message->data.size()) + " bytes)");
  }
  if (image.channels() == 4) cv::cvtColor(image, image, cv::COLOR_BGRA2BGR);
  return image;
}

}  // namespace ratslam
