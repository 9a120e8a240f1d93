/// Images from a topic, raw or compressed, as pixels: what every node that sees subscribes with.
///
/// An image that cannot be used never ends a node: it is counted, skipped and reported. So are images that are
/// dropped because they come faster than they are processed.
#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <functional>
#include <opencv2/core.hpp>
#include <string>

#include "ratslam_ros/support/counted_warning.h"
#include "ratslam_ros/support/newest_first_queue.h"
#include "ratslam_ros/support/node_params.h"
#include "ratslam_ros/support/stream_watch.h"

namespace ratslam {

/// The topic that carries the images of `base` by a transport, as image_transport finds it: a remapping of the
/// base topic holds for all of its transports.
std::string transportTopic(const ros::NodeHandle& handle, const std::string& base,
                           const std::string& transport);

/// How a stream of images fares.
struct ImageTraffic {
  std::size_t handled = 0;
  std::size_t dropped = 0;  ///< came faster than they were processed
  std::size_t skipped = 0;  ///< could not be used
  double delay_s = 0.0;     ///< from arrival to the end of processing, of the last image
  double age_s = 0.0;       ///< stamp to arrival, of the last image; tells the clocks apart, too
};

class ImageSubscriber {
 public:
  /// Gets pixels (decodeImage) and the header they came with. A std::invalid_argument about the first image
  /// goes through to the caller of ros::spin; everything else it throws is reported and the image skipped.
  using Handler = std::function<void(const std_msgs::Header&, const cv::Mat&)>;

  /// @param topic  base topic; /compressed is appended for that transport
  ImageSubscriber(const ros::NodeHandle& handle, const NodeParams& params, const std::string& topic,
                  Handler handler);

  void start();
  StreamWatch& watch() { return watch_; }
  const ImageTraffic& traffic() const { return traffic_; }

 private:
  /// One of the two is set.
  struct Waiting {
    sensor_msgs::ImageConstPtr raw;
    sensor_msgs::CompressedImageConstPtr compressed;
    ros::WallTime arrived;
    ros::Time arrived_ros;
  };

  void push(const Waiting& waiting);
  void process(const Waiting& waiting);
  std_msgs::Header headerOf(const Waiting& waiting) const;

  ros::NodeHandle handle_;
  bool compressed_;
  bool stamps_by_arrival_;
  std::string topic_;
  Handler handler_;
  StreamWatch watch_;
  NewestFirstQueue<Waiting> queue_;
  bool used_one_ = false;
  ImageTraffic traffic_;
  CountedWarning dropped_;
  CountedWarning skipped_;
  ros::Subscriber subscriber_;
};

}  // namespace ratslam
