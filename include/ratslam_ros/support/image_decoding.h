/// From image messages to pixels, whatever the driver or bag made of them.
///
/// Raw images come through cv_bridge, any row stride; compressed ones are decoded here with OpenCV, so that
/// no image_transport plugin is needed. Grey conversion is the models' own affair: pixels come out as they
/// are (8 or 16 bits; 1, 3 or 4 channels, alpha last), a Bayer mosaic as colours.
#pragma once

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <opencv2/core.hpp>
#include <stdexcept>

namespace ratslam {

/// An image message that holds no usable image; says why.
class BadImage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Takes mono8, mono16, bgr8, rgb8, bgra8, rgba8 and bayer_*. The pixels may be shared with the message.
/// @throws BadImage for an encoding that is none of these, and for sizes that contradict the data
cv::Mat decodeImage(const sensor_msgs::ImageConstPtr& message);

/// Takes JPEG, PNG and whatever else OpenCV reads.
/// @throws BadImage for corrupt or truncated data
cv::Mat decodeImage(const sensor_msgs::CompressedImageConstPtr& message);

}  // namespace ratslam
