#include "ratslam_ros/support/map_publisher.h"

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <ros/console.h>
#include <std_msgs/Float64.h>

#include <algorithm>

#include "ratslam/view/composite.h"
#include "ratslam/view/draw_map.h"
#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/map_messages.h"
#include "ratslam_ros/support/node_parameters.h"
#include "ratslam_ros/support/send_queue.h"

namespace ratslam {

MapPublisher::MapPublisher(ros::NodeHandle& handle, const NodeParams& params, bool with_scale)
    : params_(params),
      odometry_frame_(params.odomFrame()),
      picture_(handle, topicName(params.topic_root, "ExperienceMap/Picture")) {
  const auto topic = [&params](const char* name) { return topicName(params.topic_root, name); };
  const bool latched = true;
  map_ = handle.advertise<ratslam_ros::TopologicalMap>(topic("ExperienceMap/Map"), 1, latched);
  marker_ = handle.advertise<visualization_msgs::Marker>(topic("ExperienceMap/MapMarker"), 1, latched);
  path_ = handle.advertise<nav_msgs::Path>(topic("ExperienceMap/PathToGoal"), 1, latched);
  robot_pose_ = handle.advertise<geometry_msgs::PoseStamped>(topic("ExperienceMap/RobotPose"), kSendQueue);
  robot_pose_with_covariance_ = handle.advertise<geometry_msgs::PoseWithCovarianceStamped>(
      topic("ExperienceMap/RobotPoseWithCovariance"), kSendQueue);
  if (params_.publish_tf && params_.map_frame.empty()) {
    ROS_INFO("map_frame is empty: the transform from the map to the odometry is not broadcast");
    params_.publish_tf = false;
  }
  if (with_scale) scale_ = handle.advertise<std_msgs::Float64>(topic("ExperienceMap/Scale"), kSendQueue);
}

void MapPublisher::setOdometryFrame(const std::string& name) {
  odometry_frame_ = name;
  if (!params_.publish_tf || name != params_.map_frame) return;
  ROS_WARN(
      "map_frame: '%s' is also the frame of the odometry: no transform between them is broadcast; set "
      "another",
      name.c_str());
  params_.publish_tf = false;
}

std_msgs::Header MapPublisher::header() const {
  std_msgs::Header header;
  header.stamp = stampToRos(newest_);
  header.frame_id = params_.map_frame;
  return header;
}

void MapPublisher::publish(const ExperienceMap& map, const std::vector<Stamp>& processed,
                           OdometryFrame& odometry) {
  const std::vector<StampedPose>& known = map.onlineTrajectory();
  for (const Stamp stamp : processed) {
    newest_ = stamp;
    // If several decisions were processed at once, their poses are near the end of the trajectory.
    const auto at_stamp = std::find_if(known.rbegin(), known.rend(),
                                       [stamp](const StampedPose& pose) { return pose.stamp == stamp; });
    if (at_stamp == known.rend()) continue;
    geometry_msgs::PoseStamped message;
    message.header = header();
    message.pose = poseToMessage(at_stamp->pose);
    message.pose.orientation = quaternionToMessage(at_stamp->attitude());
    robot_pose_.publish(message);
    if (scale_) {
      std_msgs::Float64 scale;
      scale.data = at_stamp->pose.scale();
      scale_.publish(scale);
    }
    publishTransform(*at_stamp, odometry);
  }
  if (!processed.empty()) publishCovariance(map, processed.back());
  publishMapIfDue(map);
}

void MapPublisher::publishCovariance(const ExperienceMap& map, Stamp stamp) {
  const std::optional<Eigen::Matrix4d> known = map.robotCovariance();
  if (!known) return;
  const StampedPose robot{stamp, map.robotPose(), map.robotTilt()};
  geometry_msgs::PoseWithCovarianceStamped message;
  message.header = header();
  message.pose.pose = poseToMessage(robot.pose);
  message.pose.pose.orientation = quaternionToMessage(robot.attitude());
  message.pose.covariance = covarianceToMessage(*known);
  robot_pose_with_covariance_.publish(message);
}

void MapPublisher::followOdometry(const StampedPose& latest, OdometryFrame& odometry) {
  if (newest_transform_ && latest.stamp < *newest_transform_) newest_transform_.reset();  // time went back
  if (ahead_ && ahead_->stamp < latest.stamp) publishTransform(*ahead_, odometry);
  ahead_ = latest;
}

void MapPublisher::publishTransform(const StampedPose& robot, OdometryFrame& odometry) {
  if (!params_.publish_tf || (newest_transform_ && robot.stamp <= *newest_transform_)) return;
  const std::optional<RelativePose> in_odom = odometry.poseAt(robot.stamp);
  if (!in_odom) return;
  geometry_msgs::TransformStamped transform;
  transform.header.stamp = stampToRos(robot.stamp);
  transform.header.frame_id = params_.map_frame;
  transform.child_frame_id = odometry_frame_;
  transform.transform = transformToMessage(mapToOdom(robot.pose, *in_odom));
  broadcaster_.sendTransform(transform);
  newest_transform_ = robot.stamp;
}

void MapPublisher::publishMapIfDue(const ExperienceMap& map) {
  if (ros::WallTime::now() - published_at_ < ros::WallDuration(params_.map_period)) return;
  publishMap(map);
  publishPicture(map);
}

void MapPublisher::publishMap(const ExperienceMap& map) {
  if (map.graph().experiences().empty() || published_revision_ == map.revision()) return;
  send(map);
}

void MapPublisher::send(const ExperienceMap& map) {
  published_revision_ = map.revision();
  published_at_ = ros::WallTime::now();
  map_.publish(mapToMessage(map.graph(), header()));
  marker_.publish(markerToMessage(map.graph(), header(), params_.map_line_width));
}

void MapPublisher::publishPicture(const ExperienceMap& map) {
  const Pictured shown{map.revision(), newest_, picture_.viewers()};
  if (pictured_ == shown || map.graph().experiences().empty()) return;
  pictured_ = shown;
  published_at_ = ros::WallTime::now();
  picture_.publish(header(), [&map] { return drawMap(map.graph(), map.robotPose(), mapPictureSize()); });
}

void MapPublisher::replaceMap(const ExperienceMap& map) {
  newest_ = map.onlineTrajectory().empty() ? 0 : map.onlineTrajectory().back().stamp;
  newest_transform_.reset();
  ahead_.reset();
  pictured_.reset();
  send(map);
  publishPath(map);
}

void MapPublisher::publishPath(const ExperienceMap& map) {
  path_.publish(pathToMessage(map.pathToGoal(), header()));
}

}  // namespace ratslam
