#include "ratslam_ros/support/odometry_subscriber.h"

#include "ratslam_ros/support/conversions.h"

namespace ratslam {

OdometrySubscriber::OdometrySubscriber(const ros::NodeHandle& handle, const std::string& topic,
                                       Handler handler)
    : handle_(handle), handler_(std::move(handler)), watch_(handle.resolveName(topic), "nav_msgs/Odometry") {}

void OdometrySubscriber::start() {
  watch_.start();
  subscriber_ = handle_.subscribe<nav_msgs::Odometry>(
      watch_.topic(), 0, [this](const nav_msgs::OdometryConstPtr& message) {
        watch_.messageArrived();
        switch (handler_(odometryFromMessage(*message))) {
          case SampleVerdict::kAccepted:
            break;
          case SampleVerdict::kNotFinite:
            not_finite_.report(watch_.topic() + ": odometry dropped, it is not finite");
            break;
          case SampleVerdict::kRepeatedStamp:
            repeated_.report(watch_.topic() + ": odometry dropped, it repeats the stamp before it");
            break;
          case SampleVerdict::kTimeWentBack:
            time_went_back_.report(watch_.topic() + ": time went back, the stream starts anew");
            break;
        }
      });
}

}  // namespace ratslam
