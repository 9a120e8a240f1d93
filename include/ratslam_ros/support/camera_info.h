/// Reads a camera's calibration from sensor_msgs/CameraInfo.
#pragma once

#include <sensor_msgs/CameraInfo.h>

#include <opencv2/core.hpp>
#include <string>

#include "ratslam/camera/camera_model.h"

namespace ratslam {

/// Name of an image topic without the ending /compressed, if it has that.
std::string withoutCompressed(const std::string& image_topic);

/// Whether a topic's images are rectified, by image_proc's names: image_rect, image_rect_color.
bool isRectifiedTopic(const std::string& image_topic);

/// @param rectified   whether the images are rectified: then their camera is P without a lens, otherwise K and D. A
///                    message with P alone is for rectified images
/// @param image_size  of the images [px], if known. The message must have the same size or none, after its region of
///                    interest and binning, which move and shrink the picture
/// @throws std::invalid_argument if the message has no usable calibration, or one for another size
CameraModel cameraFromMessage(const sensor_msgs::CameraInfo& message, bool rectified = false,
                              const cv::Size& image_size = {});

}  // namespace ratslam
