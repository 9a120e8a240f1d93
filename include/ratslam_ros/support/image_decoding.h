/// Decoding of image messages for nodes and bags. No image_transport plugin is needed. For the accepted encodings see
/// ratslam/camera/image_decoding.h.
#pragma once

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <opencv2/core.hpp>
#include <string>

#include "ratslam/camera/image_decoding.h"
#include "ratslam/dataset/recording.h"

namespace ratslam {

/// @throws BadImage as decodeRaw does
cv::Mat decodeImage(const sensor_msgs::ImageConstPtr& message, const ImageLimits& limits = {});
/// @throws BadImage as decodeCompressed does
cv::Mat decodeImage(const sensor_msgs::CompressedImageConstPtr& message, const ImageLimits& limits = {});

/// The image of a message, which is decoded when it is needed. Its name is topic and stamp.
/// @param stamp  that of the message, or the time of its arrival
RecordedImage recordedImage(const sensor_msgs::ImageConstPtr& message, const std::string& topic, Stamp stamp,
                            const ImageLimits& limits);
RecordedImage recordedImage(const sensor_msgs::CompressedImageConstPtr& message, const std::string& topic,
                            Stamp stamp, const ImageLimits& limits);

}  // namespace ratslam
