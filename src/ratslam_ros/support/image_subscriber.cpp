#include "ratslam_ros/support/image_subscriber.h"

#include <cstdio>

#include "ratslam_ros/support/checked_subscription.h"
#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/image_decoding.h"

namespace ratslam {

std::string transportTopic(const ros::NodeHandle& handle, const std::string& base,
                           const std::string& transport) {
  const std::string topic = handle.resolveName(base);
  return transport == "raw" ? topic : handle.resolveName(topic + "/" + transport);
}

ImageSubscriber::ImageSubscriber(const ros::NodeHandle& handle, const NodeParams& params,
                                 const ImageStageParams& images, const std::string& topic, Handler handler)
    : handle_(handle),
      compressed_(params.image_transport == "compressed"),
      stamps_by_arrival_(params.stamp_source == "arrival"),
      topic_(transportTopic(handle, topic, params.image_transport)),
      limits_(images.limits()),
      handler_(std::move(handler)),
      stage_(images,
             [this](ImageEvent event, const std::string& text) {
               warnings_[static_cast<std::size_t>(event)].report(text);
             }),
      watch_(topic_, compressed_ ? "sensor_msgs/CompressedImage" : "sensor_msgs/Image"),
      queue_(handle, static_cast<std::size_t>(params.image_queue_size),
             [this](const Waiting& waiting) { process(waiting); }) {}

void ImageSubscriber::start() {
  if (compressed_) {
    subscribe<sensor_msgs::CompressedImage>();
  } else {
    subscribe<sensor_msgs::Image>();
  }
  watch_.start();
}

template <class Message>
void ImageSubscriber::subscribe() {
  // The subscription has an unbounded queue. The queue here is bounded; it counts and reports dropped images.
  const auto callback = [this](const ros::MessageEvent<const Message>& event) {
    const boost::shared_ptr<const Message>& message = event.getConstMessage();
    Waiting waiting{message->header, {}, ros::WallTime::now(), ros::Time::now()};
    if (stamps_by_arrival_) waiting.header.stamp = waiting.arrived_ros;
    waiting.image = recordedImage(message, topic_, stampFromRos(waiting.header.stamp), limits_);
    push(waiting);
  };
  const auto refused = [this](const std::string& why) {
    Waiting waiting{{}, {}, ros::WallTime::now(), ros::Time::now()};
    waiting.header.stamp = waiting.arrived_ros;
    waiting.image.stamp = stampFromRos(waiting.header.stamp);
    waiting.image.name = topic_;
    waiting.image.decode = [why]() -> cv::Mat { throw BadImage(why); };
    push(waiting);
  };
  subscriber_ = subscribeChecked<Message>(handle_, topic_, 0, callback, refused);
}

void ImageSubscriber::push(const Waiting& waiting) {
  watch_.messageArrived();
  const std::size_t dropped = queue_.push(waiting);
  traffic_.dropped += dropped;
  if (const auto on_arrival = on_arrival_) on_arrival(waiting.image);  // which may end the hold
  if (dropped == 0) return;
  if (on_arrival_) return dropped_.report(topic_ + ": images dropped while they wait", traffic_.dropped);
  char text[200];
  std::snprintf(text, sizeof(text),
                ": images dropped, they come faster than they are processed; results are %.2f s behind; "
                "image_queue_size: 0 keeps all, as a bag needs",
                traffic_.delay_s);
  dropped_.report(topic_ + text, traffic_.dropped);
}

void ImageSubscriber::process(const Waiting& waiting) {
  // ros::Time's own difference throws if stamps are 68 years apart.
  traffic_.age_s = waiting.arrived_ros.toSec() - waiting.header.stamp.toSec();
  try {
    const std::optional<ImageFrame> frame = stage_.add(decodeNow(waiting.image));
    if (frame) handler_(waiting.header, *frame);
  } catch (const std::exception& e) {
    stage_.refused(waiting.image.name, e.what());
  }
  traffic_.delay_s = (ros::WallTime::now() - waiting.arrived).toSec();
}

}  // namespace ratslam
