/// A camera's calibration out of sensor_msgs/CameraInfo.
#pragma once

#include <sensor_msgs/CameraInfo.h>

#include <opencv2/core.hpp>
#include <string>

#include "ratslam/camera/camera_model.h"

namespace ratslam {

/// Whether a topic's images are rectified, by the name that image_proc gives it: image_rect, image_rect_color.
bool isRectifiedTopic(const std::string& image_topic);

/// @param rectified   the images are rectified: their camera is P, which has no lens; else K and D
/// @param image_size  of the images [px], where it is known: that of the message must be the same, unless it has none;
///                    a message that holds P alone is of rectified images
/// @throws std::invalid_argument where the message holds no usable calibration, or one for images of another size
CameraModel cameraFromMessage(const sensor_msgs::CameraInfo& message, bool rectified = false,
                              const cv::Size& image_size = {});

}  // namespace ratslam
