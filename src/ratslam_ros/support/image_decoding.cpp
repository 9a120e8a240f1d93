#include "ratslam_ros/support/image_decoding.h"

#include "ratslam/common/stamp.h"

namespace ratslam {
namespace {

template <class Message>
RecordedImage recorded(const boost::shared_ptr<const Message>& message, const std::string& topic, Stamp stamp,
                       const ImageLimits& limits) {
  RecordedImage image;
  image.stamp = stamp;
  image.name = topic + " at " + formatStamp(image.stamp);
  image.decode = [message, limits] { return decodeImage(message, limits); };
  return image;
}

}  // namespace

cv::Mat decodeImage(const sensor_msgs::ImageConstPtr& message, const ImageLimits& limits) {
  RawImage image;
  image.width = message->width;
  image.height = message->height;
  image.step = message->step;
  image.encoding = message->encoding;
  image.big_endian = message->is_bigendian != 0;
  image.data = message->data.data();
  image.size = message->data.size();
  return decodeRaw(image, limits);
}

cv::Mat decodeImage(const sensor_msgs::CompressedImageConstPtr& message, const ImageLimits& limits) {
  return decodeCompressed(message->data.data(), message->data.size(), limits);
}

RecordedImage recordedImage(const sensor_msgs::ImageConstPtr& message, const std::string& topic, Stamp stamp,
                            const ImageLimits& limits) {
  return recorded(message, topic, stamp, limits);
}

RecordedImage recordedImage(const sensor_msgs::CompressedImageConstPtr& message, const std::string& topic,
                            Stamp stamp, const ImageLimits& limits) {
  return recorded(message, topic, stamp, limits);
}

}  // namespace ratslam
