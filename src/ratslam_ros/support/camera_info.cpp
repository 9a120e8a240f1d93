#include "ratslam_ros/support/camera_info.h"

#include <stdexcept>

namespace ratslam {

bool isRectifiedTopic(const std::string& image_topic) {
  const std::string compressed = "/compressed";
  std::string topic = image_topic;
  if (topic.size() > compressed.size() &&
      topic.compare(topic.size() - compressed.size(), compressed.size(), compressed) == 0) {
    topic.erase(topic.size() - compressed.size());
  }
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
  const bool has_size = message.width > 0 && message.height > 0;
  camera.width = has_size ? static_cast<int>(message.width) : image_size.width;
  camera.height = has_size ? static_cast<int>(message.height) : image_size.height;
  camera.fx = by_p ? message.P[0] : message.K[0];
  camera.fy = by_p ? message.P[5] : message.K[4];
  camera.cx = by_p ? message.P[2] : message.K[2];
  camera.cy = by_p ? message.P[6] : message.K[5];
  const bool lens = !rectified && !by_p;
  CameraModel made = makeCamera(camera, message.distortion_model, lens ? message.D : std::vector<double>{});
  if (!image_size.empty() && cv::Size(made.width, made.height) != image_size) {
    throw std::invalid_argument("it is for images of " + std::to_string(made.width) + "x" +
                                std::to_string(made.height) + ", they are of " +
                                std::to_string(image_size.width) + "x" + std::to_string(image_size.height));
  }
  return made;
}

}  // namespace ratslam
