#include "ratslam_ros/support/image_subscriber.h"

#include "ratslam_ros/support/image_decoding.h"

namespace ratslam {

ImageSubscriber::ImageSubscriber(const ros::NodeHandle& handle, const NodeParams& params,
                                 const std::string& topic, Handler handler)
    : handle_(handle),
      compressed_(params.image_transport == "compressed"),
      topic_(handle.resolveName(compressed_ ? topic + "/compressed" : topic)),
      queue_size_(static_cast<std::uint32_t>(params.image_queue_size)),
      handler_(std::move(handler)),
      watch_(topic_, compressed_ ? "sensor_msgs/CompressedImage" : "sensor_msgs/Image") {}

void ImageSubscriber::start() {
  if (compressed_) {
    subscriber_ = handle_.subscribe<sensor_msgs::CompressedImage>(
        topic_, queue_size_,
        [this](const sensor_msgs::CompressedImageConstPtr& message) { handle(message); });
  } else {
    subscriber_ = handle_.subscribe<sensor_msgs::Image>(
        topic_, queue_size_, [this](const sensor_msgs::ImageConstPtr& message) { handle(message); });
  }
  watch_.start();
}

template <class Message>
void ImageSubscriber::handle(const boost::shared_ptr<const Message>& message) {
  watch_.messageArrived();
  countLost(message->header.seq);
  try {
    handler_(message->header, decodeImage(message));
    used_one_ = true;
  } catch (const std::invalid_argument& e) {
    if (!used_one_) throw;
    skipped_.report(topic_ + ": image skipped: " + e.what());
  } catch (const std::exception& e) {
    skipped_.report(topic_ + ": image skipped: " + e.what());
  }
}

void ImageSubscriber::countLost(std::uint32_t sequence) {
  // Publishers number their messages without gaps; one that starts anew counts from a lower number.
  if (last_sequence_ && sequence > *last_sequence_ + 1) {
    lost_count_ += sequence - *last_sequence_ - 1;
    lost_.report(topic_ + ": " + std::to_string(lost_count_) +
                 " images lost, they come faster than they are processed or the line drops them");
  }
  last_sequence_ = sequence;
}

}  // namespace ratslam
