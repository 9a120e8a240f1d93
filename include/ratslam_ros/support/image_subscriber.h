/// Images from a topic, raw or compressed, as pixels: what every node that sees subscribes with.
///
/// An image that cannot be used never ends a node: it is counted, skipped and reported. So are images that
/// were lost because they came faster than they were processed.
#pragma once

#include <ros/node_handle.h>
#include <std_msgs/Header.h>

#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "ratslam_ros/support/counted_warning.h"
#include "ratslam_ros/support/node_params.h"
#include "ratslam_ros/support/stream_watch.h"

namespace ratslam {

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

  std::size_t lost() const { return lost_count_; }
  std::size_t skipped() const { return skipped_.count(); }

 private:
  template <class Message>
  void handle(const boost::shared_ptr<const Message>& message);
  void countLost(std::uint32_t sequence);

  ros::NodeHandle handle_;
  bool compressed_;
  std::string topic_;
  std::uint32_t queue_size_;
  Handler handler_;
  StreamWatch watch_;
  std::optional<std::uint32_t> last_sequence_;
  bool used_one_ = false;
  std::size_t lost_count_ = 0;
  CountedWarning lost_;
  CountedWarning skipped_;
  ros::Subscriber subscriber_;
};

}  // namespace ratslam
