#include "ratslam_ros/support/start_gate.h"

#include <ros/console.h>
#include <std_msgs/Empty.h>

#include <algorithm>

namespace ratslam {
namespace {

const ros::WallDuration kPollPeriod(0.05);
const ros::WallDuration kPatience(15.0);

}  // namespace

StartGate::StartGate(const ros::NodeHandle& handle, const ros::NodeHandle& own,
                     std::vector<ros::Publisher> outputs, int count, std::function<void()> start)
    : own_(own),
      outputs_(std::move(outputs)),
      count_(static_cast<std::uint32_t>(count)),
      start_(std::move(start)),
      since_(ros::WallTime::now()) {
  if (count_ == 0) {
    open();
    return;
  }
  timer_ = handle.createWallTimer(kPollPeriod, [this](const ros::WallTimerEvent&) { check(); });
}

void StartGate::check() {
  const auto lonely = std::find_if(outputs_.begin(), outputs_.end(), [this](const ros::Publisher& output) {
    return output.getNumSubscribers() < count_;
  });
  if (lonely != outputs_.end()) {
    if (ros::WallTime::now() - since_ < kPatience) return;
    ROS_WARN("%s has %u of the %u subscribers to wait for after %.0f s: starting without",
             lonely->getTopic().c_str(), lonely->getNumSubscribers(), count_, kPatience.toSec());
  }
  timer_.stop();
  open();
}

void StartGate::open() {
  start_();
  started_ = own_.advertise<std_msgs::Empty>("started", 1);
}

}  // namespace ratslam
