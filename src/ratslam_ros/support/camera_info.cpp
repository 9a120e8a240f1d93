#include "ratslam_ros/support/camera_info.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "ratslam/common/params.h"
#include "ratslam/common/text_file.h"

namespace ratslam {
namespace {

/// Size of the images by the message, and the position of their pixels on the whole sensor.
struct Readout {
  cv::Size size;  ///< [px]; empty if the message has none
  double binning_x = 1.0;
  double binning_y = 1.0;
  double left = 0.0;  ///< of the region of interest [px of the sensor]
  double top = 0.0;
  bool whole = true;

  std::string text() const {
    const std::string of = std::to_string(size.width) + "x" + std::to_string(size.height);
    return whole ? of : of + " (after its region of interest and binning)";
  }
};

/// @throws std::invalid_argument if a size is too large, the region of interest leaves the sensor, or binning leaves no
/// pixel
Readout readoutOf(const sensor_msgs::CameraInfo& message) {
  constexpr std::uint32_t kMostPixels = 65535;  // as CameraModel allows
  if (message.width == 0 || message.height == 0) return {};
  for (const std::uint32_t pixels : {message.width, message.height}) {
    if (pixels > kMostPixels) throwBadValue("width or height", pixels, "it must lie within [0, 65535] px");
  }
  const auto& region = message.roi;
  const bool all = region.width == 0 && region.height == 0;
  const std::uint32_t width = all ? message.width : region.width;
  const std::uint32_t height = all ? message.height : region.height;
  const std::uint32_t binning_x = std::max(message.binning_x, 1U);
  const std::uint32_t binning_y = std::max(message.binning_y, 1U);
  const auto beyond = [](std::uint64_t offset, std::uint32_t extent, std::uint32_t most) {
    return extent == 0 || offset + extent > most;
  };
  if (beyond(region.x_offset, width, message.width) || beyond(region.y_offset, height, message.height)) {
    throw std::invalid_argument("its region of interest, " + std::to_string(region.width) + "x" +
                                std::to_string(region.height) + " from (" + std::to_string(region.x_offset) +
                                ", " + std::to_string(region.y_offset) + "), does not lie within its " +
                                std::to_string(message.width) + "x" + std::to_string(message.height) +
                                " pixels");
  }
  if (binning_x > width || binning_y > height) {
    throw std::invalid_argument("binning of " + std::to_string(binning_x) + "x" + std::to_string(binning_y) +
                                " leaves no pixel");
  }
  Readout readout;
  readout.size = cv::Size(static_cast<int>(width / binning_x), static_cast<int>(height / binning_y));
  readout.binning_x = binning_x;
  readout.binning_y = binning_y;
  readout.left = region.x_offset;
  readout.top = region.y_offset;
  readout.whole = width == message.width && height == message.height && binning_x == 1 && binning_y == 1;
  return readout;
}

}  // namespace

std::string withoutCompressed(const std::string& image_topic) {
  const std::string ending = "/compressed";
  if (!endsWith(image_topic, ending) || image_topic == ending) return image_topic;
  return image_topic.substr(0, image_topic.size() - ending.size());
}

bool isRectifiedTopic(const std::string& image_topic) {
  const std::string topic = withoutCompressed(image_topic);
  const std::string rectified = "image_rect";
  return topic.compare(topic.rfind('/') + 1, rectified.size(), rectified) == 0;
}

CameraModel cameraFromMessage(const sensor_msgs::CameraInfo& message, bool rectified,
                              const cv::Size& image_size) {
  const bool has_k = message.K[0] != 0.0 || message.K[4] != 0.0;
  const bool has_p = message.P[0] != 0.0 || message.P[5] != 0.0;
  if (!has_k && !has_p) {
    throw std::invalid_argument("K and P are all zero, as drivers send without a calibration");
  }
  const bool by_p = has_p && (rectified || !has_k);
  CameraModel camera;
  const Readout readout = readoutOf(message);
  const cv::Size size = readout.size.empty() ? image_size : readout.size;
  camera.width = size.width;
  camera.height = size.height;
  // K and P are those of the whole sensor. The middle of a binned pixel lies between those of its pixels.
  const auto binned = [](double centre, double offset, double binning) {
    return binning == 1.0 ? centre - offset : (centre - offset + 0.5) / binning - 0.5;
  };
  const double* matrix = by_p ? message.P.data() : message.K.data();
  const int columns = by_p ? 4 : 3;
  camera.fx = matrix[0] / readout.binning_x;
  camera.fy = matrix[columns + 1] / readout.binning_y;
  camera.cx = binned(matrix[2], readout.left, readout.binning_x);
  camera.cy = binned(matrix[columns + 2], readout.top, readout.binning_y);
  const bool lens = !rectified && !by_p;
  CameraModel made = makeCamera(camera, message.distortion_model, lens ? message.D : std::vector<double>{});
  requireNoSkew(by_p ? "P[1]" : "K[1]", matrix[1] / readout.binning_x, made);
  if (!image_size.empty() && size != image_size) {
    throw std::invalid_argument("it is for images of " + readout.text() + ", they are of " +
                                std::to_string(image_size.width) + "x" + std::to_string(image_size.height));
  }
  return made;
}

}  // namespace ratslam
