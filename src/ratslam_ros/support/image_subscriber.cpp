#include "ratslam_ros/support/image_subscriber.h"

#include <cstdio>

#include "ratslam_ros/support/image_decoding.h"

namespace ratslam {

std::string transportTopic(const ros::NodeHandle& handle, const std::string& base,
                           const std::string& transport) {
  const std::string topic = handle.resolveName(base);
  return transport == "raw" ? topic : handle.resolveName(topic + "/" + transport);
}

ImageSubscriber::ImageSubscriber(const ros::NodeHandle& handle, const NodeParams& params,
                                 const std::string& topic, Handler handler)
    : handle_(handle),
      compressed_(params.image_transport == "compressed"),
      stamps_by_arrival_(params.stamp_source == "arrival"),
      topic_(transportTopic(handle, topic, params.image_transport)),
      handler_(std::move(handler)),
      watch_(topic_, compressed_ ? "sensor_msgs/CompressedImage" : "sensor_msgs/Image"),
      queue_(handle, static_cast<std::size_t>(params.image_queue_size),
             [this](const Waiting& waiting) { process(waiting); }) {}

void ImageSubscriber::start() {
  // The subscription itself has no bound: what waits is bounded, counted and reported here.
  if (compressed_) {
    subscriber_ = handle_.subscribe<sensor_msgs::CompressedImage>(
        topic_, 0, [this](const sensor_msgs::CompressedImageConstPtr& message) {
          push({nullptr, message, ros::WallTime::now(), ros::Time::now()});
        });
  } else {
    subscriber_ =
        handle_.subscribe<sensor_msgs::Image>(topic_, 0, [this](const sensor_msgs::ImageConstPtr& message) {
          push({message, nullptr, ros::WallTime::now(), ros::Time::now()});
        });
  }
  watch_.start();
}

void ImageSubscriber::push(const Waiting& waiting) {
  watch_.messageArrived();
  const std::size_t dropped = queue_.push(waiting);
  traffic_.dropped += dropped;
  if (dropped == 0) return;
  char text[160];
  std::snprintf(text, sizeof(text),
                ": images dropped, they come faster than they are processed; results are %.2f s behind",
                traffic_.delay_s);
  dropped_.report(topic_ + text, traffic_.dropped);
}

std_msgs::Header ImageSubscriber::headerOf(const Waiting& waiting) const {
  std_msgs::Header header = waiting.raw ? waiting.raw->header : waiting.compressed->header;
  if (stamps_by_arrival_) header.stamp = waiting.arrived_ros;
  return header;
}

void ImageSubscriber::process(const Waiting& waiting) {
  const std_msgs::Header header = headerOf(waiting);
  traffic_.age_s = (waiting.arrived_ros - header.stamp).toSec();
  try {
    handler_(header, waiting.raw ? decodeImage(waiting.raw) : decodeImage(waiting.compressed));
    used_one_ = true;
    ++traffic_.handled;
  } catch (const std::invalid_argument& e) {
    if (!used_one_) throw;
    skipped_.report(topic_ + ": image skipped: " + e.what());
  } catch (const std::exception& e) {
    skipped_.report(topic_ + ": image skipped: " + e.what());
  }
  traffic_.skipped = skipped_.count();
  traffic_.delay_s = (ros::WallTime::now() - waiting.arrived).toSec();
}

}  // namespace ratslam
