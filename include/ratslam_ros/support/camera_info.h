/// sensor_msgs/CameraInfo as the core's camera model.
#pragma once

#include <sensor_msgs/CameraInfo.h>

#include "ratslam/camera/camera_model.h"

namespace ratslam {

/// The calibration of the image as it comes: K, D and the distortion model.
/// @throws std::invalid_argument where the message holds no calibration (K all zero) or an unknown model
CameraModel cameraFromMessage(const sensor_msgs::CameraInfo& message);

}  // namespace ratslam
