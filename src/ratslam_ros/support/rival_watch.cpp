#include "ratslam_ros/support/rival_watch.h"

#include <ros/console.h>
#include <ros/master.h>
#include <ros/this_node.h>
#include <xmlrpcpp/XmlRpcException.h>

#include <algorithm>

namespace ratslam {
namespace {

const ros::WallDuration kPeriod(3.0);

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " and ") + name;
  return text;
}

}  // namespace

std::vector<std::string> publishersOf(const std::string& topic) {
  XmlRpc::XmlRpcValue request;
  XmlRpc::XmlRpcValue response;
  XmlRpc::XmlRpcValue state;
  request[0] = ros::this_node::getName();
  const bool wait_for_master = false;
  if (!ros::master::execute("getSystemState", request, response, state, wait_for_master)) return {};
  std::vector<std::string> names;
  try {
    XmlRpc::XmlRpcValue& publishers = state[0];
    for (int i = 0; i < publishers.size(); ++i) {
      if (static_cast<std::string>(publishers[i][0]) != topic) continue;
      for (int j = 0; j < publishers[i][1].size(); ++j) names.push_back(publishers[i][1][j]);
    }
  } catch (const XmlRpc::XmlRpcException&) {  // no valid answer of the master; try again later
    return {};
  }
  return names;
}

RivalWatch::RivalWatch(const ros::NodeHandle& handle, std::string odometry_topic)
    : odometry_topic_(std::move(odometry_topic)) {
  ros::NodeHandle nodes(handle);
  for (const char* topic : {"/tf", "/tf_static"}) {
    subscribers_.push_back(subscribeChecked<tf2_msgs::TFMessage>(
        nodes, topic, 100,
        [this](const ros::MessageEvent<tf2_msgs::TFMessage const>& event) { onTransforms(event); },
        [this, topic](const std::string& why) {
          damaged_.report(std::string(topic) + ": message dropped: " + why);
        }));
  }
  timer_ = nodes.createWallTimer(kPeriod, [this](const ros::WallTimerEvent&) { checkOdometry(); });
}

void RivalWatch::onTransforms(const ros::MessageEvent<tf2_msgs::TFMessage const>& event) {
  for (const geometry_msgs::TransformStamped& transform : event.getConstMessage()->transforms) {
    const auto known = broadcasters_.find(transform.child_frame_id);
    if (known == broadcasters_.end()) continue;
    std::set<std::string>& nodes = known->second;
    if (!nodes.insert(event.getPublisherName()).second || nodes.size() != 2) continue;
    ROS_ERROR(
        "tf: the transform %s -> %s is broadcast by %s: only one may. Leave it to one of them (this package: "
        "publish_tf:=false, and odometry:=external if the robot has its own odometry)",
        transform.header.frame_id.c_str(), transform.child_frame_id.c_str(),
        joined({nodes.begin(), nodes.end()}).c_str());
  }
}

void RivalWatch::checkOdometry() {
  std::vector<std::string> names = publishersOf(odometry_topic_);
  if (names.size() < 2) return;
  timer_.stop();  // report only once
  std::sort(names.begin(), names.end());
  ROS_ERROR(
      "%s is published by %s: the map would be made of both. Leave it to one of them (odometry:=external: "
      "this package "
      "publishes none), or choose the topic of one (odom:=TOPIC)",
      odometry_topic_.c_str(), joined(names).c_str());
}

}  // namespace ratslam
