#include "ratslam_ros/support/camera_info.h"

#include <algorithm>

namespace ratslam {

CameraModel cameraFromMessage(const sensor_msgs::CameraInfo& message) {
  const bool distorts = std::any_of(message.D.begin(), message.D.end(), [](double d) { return d != 0.0; });
  CameraModel camera;
  camera.width = static_cast<int>(message.width);
  camera.height = static_cast<int>(message.height);
  camera.fx = message.K[0];
  camera.fy = message.K[4];
  camera.cx = message.K[2];
  camera.cy = message.K[5];
  if (distorts) {
    camera.model = lensModelFromName(message.distortion_model);
    camera.coefficients = message.D;
  }
  camera.validate();
  return camera;
}

}  // namespace ratslam
