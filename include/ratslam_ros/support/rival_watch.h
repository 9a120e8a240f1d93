/// Others that publish what we publish: a second odometry on the topic, a second broadcaster of a transform. Two of
/// either make a map of nothing, and neither of them can know.
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

  /// The child of a transform that one node may broadcast.
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

/// Nodes that publish a topic, as the master knows them; empty where the master does not answer.
std::vector<std::string> publishersOf(const std::string& topic);

}  // namespace ratslam
