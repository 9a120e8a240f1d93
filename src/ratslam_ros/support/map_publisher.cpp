#include "ratslam_ros/support/map_publisher.h"

#include <std_msgs/Float64.h>

#include <algorithm>

#include "ratslam/view/composite.h"
#include "ratslam/view/draw_map.h"
#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/map_messages.h"
#include "ratslam_ros/support/node_parameters.h"

namespace ratslam {

MapPublisher::MapPublisher(ros::NodeHandle& handle, const NodeParams& params, bool with_scale)
    : params_(params), picture_(handle, topicName(params.topic_root, "ExperienceMap/Picture")) {
  const auto topic = [&params](const char* name) { return topicName(params.topic_root, name); };
  const bool latched = true;
  map_ = handle.advertise<ratslam_ros::TopologicalMap>(topic("ExperienceMap/Map"), 1, latched);
  marker_ = handle.advertise<visualization_msgs::Marker>(topic("ExperienceMap/MapMarker"), 1, latched);
  path_ = handle.advertise<nav_msgs::Path>(topic("ExperienceMap/PathToGoal"), 1, latched);
  robot_pose_ = handle.advertise<geometry_msgs::PoseStamped>(topic("ExperienceMap/RobotPose"), 0);
  if (with_scale) scale_ = handle.advertise<std_msgs::Float64>(topic("ExperienceMap/Scale"), 0);
}

std_msgs::Header MapPublisher::header() const {
  std_msgs::Header header;
  header.stamp = stampToRos(newest_);
  header.frame_id = params_.map_frame;
  return header;
}

void MapPublisher::publishPoses(const ExperienceMap& map, const std::vector<Stamp>& processed,
                                OdometryFrame& odometry) {
  const std::vector<StampedPose>& known = map.onlineTrajectory();
  for (const Stamp stamp : processed) {
    newest_ = stamp;
    // Several decisions may have been processed at once: each has its pose in the trajectory, near the end.
    const auto at_stamp = std::find_if(known.rbegin(), known.rend(),
                                       [stamp](const StampedPose& pose) { return pose.stamp == stamp; });
    if (at_stamp == known.rend()) continue;
    geometry_msgs::PoseStamped message;
    message.header = header();
    message.pose = poseToMessage(at_stamp->pose);
    robot_pose_.publish(message);
    if (scale_) {
      std_msgs::Float64 scale;
      scale.data = at_stamp->pose.scale();
      scale_.publish(scale);
    }
    if (!params_.publish_tf || newest_transform_ == stamp) continue;
    if (const std::optional<RelativePose> in_odom = odometry.poseAt(stamp)) {
      geometry_msgs::TransformStamped transform;
      transform.header = message.header;
      transform.child_frame_id = params_.odom_frame;
      transform.transform = transformToMessage(mapToOdom(at_stamp->pose, *in_odom));
      broadcaster_.sendTransform(transform);
      newest_transform_ = stamp;
    }
  }
}

void MapPublisher::publishMapIfDue(const ExperienceMap& map) {
  if (ros::WallTime::now() - published_at_ >= ros::WallDuration(params_.map_period)) publishMap(map);
}

void MapPublisher::publishMap(const ExperienceMap& map) {
  if (map.graph().experiences().empty() || published_revision_ == map.revision()) return;
  published_revision_ = map.revision();
  published_at_ = ros::WallTime::now();
  map_.publish(mapToMessage(map.graph(), header()));
  marker_.publish(markerToMessage(map.graph(), header(), params_.map_line_width));
  picture_.publish(header(), [&map] { return drawMap(map.graph(), map.robotPose(), mapPictureSize()); });
}

void MapPublisher::publishPath(const ExperienceMap& map) {
  path_.publish(pathToMessage(map.pathToGoal(), header()));
}

}  // namespace ratslam
