/// Detects other publishers of our data: a second odometry on the topic, or a second broadcaster of a transform. With
/// two of them the map is useless, and no message shows why.
#pragma once

#include <ros/message_event.h>
#include <ros/node_handle.h>
#include <tf2_msgs/TFMessage.h>

#include <map>
#include <set>
#include <string>
#include <vector>

#include "ratslam_ros/support/checked_subscription.h"
#include "ratslam_ros/support/counted_warning.h"

namespace ratslam {

class RivalWatch {
 public:
  /// @param odometry_topic  resolved name
  RivalWatch(const ros::NodeHandle& handle, std::string odometry_topic);

  /// Watches a transform that only one node may broadcast. @param frame its child frame
  void watchFrame(const std::string& frame) { broadcasters_[frame]; }

 private:
  void onTransforms(const ros::MessageEvent<tf2_msgs::TFMessage const>& event);
  void checkOdometry();

  std::string odometry_topic_;
  std::map<std::string, std::set<std::string>> broadcasters_;  ///< by child frame
  CountedWarning damaged_;
  std::vector<ros::Subscriber> subscribers_;
  ros::WallTimer timer_;
};

/// Nodes that publish a topic, by the master; empty if the master does not answer.
std::vector<std::string> publishersOf(const std::string& topic);

}  // namespace ratslam
