/// Image messages as images still to be decoded, the same for nodes and bags; no image_transport plugin is
/// needed. What encodings are taken: ratslam/camera/image_decoding.h.
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

/// The image of a message, to be decoded when it is wanted; named by topic and stamp.
/// @param stamp  the message's own, or when it arrived
RecordedImage recordedImage(const sensor_msgs::ImageConstPtr& message, const std::string& topic, Stamp stamp,
                            const ImageLimits& limits);
RecordedImage recordedImage(const sensor_msgs::CompressedImageConstPtr& message, const std::string& topic,
                            Stamp stamp, const ImageLimits& limits);

}  // namespace ratslam
