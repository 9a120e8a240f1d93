#include "ratslam_ros/support/message_guard.h"

#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/this_node.h>

namespace ratslam {

void MessageGuard::publishCounts(const ros::NodeHandle& handle, const std::string& part) {
  part_ = part;
  ros::NodeHandle advertiser(handle);
  diagnostics_ = advertiser.advertise<diagnostic_msgs::DiagnosticArray>("/diagnostics", 10);
  timer_ =
      advertiser.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) { publish(); });
}

std::size_t MessageGuard::dropped(const std::string& topic) const {
  const auto found = dropped_.find(topic);
  return found == dropped_.end() ? 0 : found->second.count();
}

void MessageGuard::number(const std::string& topic, const std::string& publisher, std::uint32_t seq) {
  Losses& losses = losses_[topic];
  const std::size_t lost = losses.watch.messageOf(publisher, seq);
  if (lost == 0) return;
  losses.warning.report(
      topic + ": messages of " + publisher + " were lost: this node did not read them in time",
      losses.warning.count() + lost);
}

std::size_t MessageGuard::lost(const std::string& topic) const {
  const auto found = losses_.find(topic);
  return found == losses_.end() ? 0 : found->second.warning.count();
}

void MessageGuard::publish() {
  diagnostic_msgs::DiagnosticStatus status;
  status.name = ros::this_node::getName().substr(1) + ": " + part_;
  status.level =
      dropped_.empty() ? diagnostic_msgs::DiagnosticStatus::OK : diagnostic_msgs::DiagnosticStatus::WARN;
  status.message = dropped_.empty() ? "none dropped" : "some could not be processed";
  for (const auto& [topic, warning] : dropped_) {
    diagnostic_msgs::KeyValue value;
    value.key = "dropped " + topic;
    value.value = std::to_string(warning.count());
    status.values.push_back(value);
  }
  for (const auto& [topic, losses] : losses_) {
    if (losses.warning.count() == 0) continue;
    diagnostic_msgs::KeyValue value;
    value.key = "lost " + topic;
    value.value = std::to_string(losses.warning.count());
    status.values.push_back(value);
  }
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = ros::Time::now();
  message.status.push_back(status);
  diagnostics_.publish(message);
}

}  // namespace ratslam
