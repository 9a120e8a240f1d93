/// An image topic whose pictures are drawn only while it has subscribers. It is latched: a new subscriber gets the last
/// picture.
#pragma once

#include <cv_bridge/cv_bridge.h>
#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <string>

namespace ratslam {

class LazyPicture {
 public:
  LazyPicture(ros::NodeHandle& handle, const std::string& topic)
      : publisher_(handle.advertise<sensor_msgs::Image>(topic, 1, true)) {}

  std::uint32_t viewers() const { return publisher_.getNumSubscribers(); }

  /// @param draw  returns an 8-bit BGR picture; called only if there are subscribers
  template <class Draw>
  void publish(const std_msgs::Header& header, Draw&& draw) const {
    if (viewers() > 0) publisher_.publish(cv_bridge::CvImage(header, "bgr8", draw()).toImageMsg());
  }

 private:
  ros::Publisher publisher_;
};

}  // namespace ratslam
