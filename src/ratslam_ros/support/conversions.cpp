#include "ratslam_ros/support/conversions.h"

#include <limits>
#include <stdexcept>
#include <string>

namespace ratslam {
namespace {

constexpr Stamp kNanosecondsPerSecond = 1000000000;

std_msgs::Header headerAt(Stamp stamp) {
  std_msgs::Header header;
  header.stamp = stampToRos(stamp);
  return header;
}

ActionKind actionKind(std::uint32_t number) {
  if (number > static_cast<std::uint32_t>(ActionKind::kSetNode)) {
    throw std::runtime_error("action " + std::to_string(number) +
                             " is unknown: it must be 1 (create node), 2 (create edge) or 3 (set node)");
  }
  return static_cast<ActionKind>(number);
}

/// Both messages that carry a decision name its fields alike.
template <class Message>
TopologicalAction decisionIn(const Message& message) {
  TopologicalAction action;
  action.stamp = stampFromRos(message.header.stamp);
  action.kind = actionKind(message.action);
  action.src_id = message.src_id;
  action.dest_id = message.dest_id;
  action.relative_rad = message.relative_rad;
  return action;
}

}  // namespace

Stamp stampFromRos(const ros::Time& time) { return kNanosecondsPerSecond * time.sec + time.nsec; }

ros::Time stampToRos(Stamp stamp) {
  if (stamp < 0 || stamp / kNanosecondsPerSecond > std::numeric_limits<std::uint32_t>::max()) {
    throw std::runtime_error("the stamp " + std::to_string(stamp) + " ns is outside the range of ROS time");
  }
  return {static_cast<std::uint32_t>(stamp / kNanosecondsPerSecond),
          static_cast<std::uint32_t>(stamp % kNanosecondsPerSecond)};
}

OdometrySample odometryFromMessage(const nav_msgs::Odometry& message) {
  OdometrySample sample;
  sample.stamp = stampFromRos(message.header.stamp);
  sample.speed = message.twist.twist.linear.x;
  sample.yaw_rate = message.twist.twist.angular.z;
  const geometry_msgs::Quaternion& q = message.pose.pose.orientation;
  const geometry_msgs::Point& p = message.pose.pose.position;
  const Eigen::Quaterniond orientation(q.w, q.x, q.y, q.z);
  if (orientation.squaredNorm() != 0.0) {
    sample.pose = Eigen::Isometry3d::Identity();
    sample.pose->linear() = orientation.normalized().toRotationMatrix();
    sample.pose->translation() = Eigen::Vector3d(p.x, p.y, p.z);
  }
  return sample;
}

ViewEvent viewFromMessage(const ratslam_ros::ViewTemplate& message) {
  ViewEvent view;
  view.stamp = stampFromRos(message.header.stamp);
  view.id = message.current_id;
  view.relative_rad = message.relative_rad;
  return view;
}

ratslam_ros::ViewTemplate viewToMessage(const ViewEvent& view) {
  ratslam_ros::ViewTemplate message;
  message.header = headerAt(view.stamp);
  message.current_id = view.id;
  message.relative_rad = view.relative_rad;
  return message;
}

TopologicalAction actionFromMessage(const ratslam_ros::TopologicalAction& message) {
  return decisionIn(message);
}

TopologicalAction actionFromMessage(const ratslam_ros::PoseCellState& message) { return decisionIn(message); }

ratslam_ros::TopologicalAction actionToMessage(const TopologicalAction& action) {
  ratslam_ros::TopologicalAction message;
  message.header = headerAt(action.stamp);
  message.action = static_cast<std::uint32_t>(action.kind);
  message.src_id = action.src_id;
  message.dest_id = action.dest_id;
  message.relative_rad = action.relative_rad;
  return message;
}

RecallGeometry geometryFromMessage(const ratslam_ros::RecallGeometry& message) {
  RecallGeometry geometry;
  geometry.stamp = stampFromRos(message.header.stamp);
  geometry.view_id = message.view_id;
  geometry.relative_rad = message.relative_rad;
  geometry.direction_rad = message.direction_rad;
  geometry.distance = message.distance;
  geometry.sigma_distance = message.sigma_distance;
  geometry.sigma_rotation = message.sigma_rotation;
  geometry.sigma_direction = message.sigma_direction;
  geometry.inliers = static_cast<int>(message.inliers);
  geometry.template_stamp = stampFromRos(message.template_stamp);
  geometry.companion_stamp = stampFromRos(message.companion_stamp);
  geometry.distance_ratio = message.distance_ratio;
  geometry.sigma_ratio = message.sigma_ratio;
  return geometry;
}

ratslam_ros::RecallGeometry geometryToMessage(const RecallGeometry& geometry) {
  ratslam_ros::RecallGeometry message;
  message.header = headerAt(geometry.stamp);
  message.view_id = geometry.view_id;
  message.relative_rad = geometry.relative_rad;
  message.direction_rad = geometry.direction_rad;
  message.distance = geometry.distance;
  message.sigma_distance = geometry.sigma_distance;
  message.sigma_rotation = geometry.sigma_rotation;
  message.sigma_direction = geometry.sigma_direction;
  message.inliers = static_cast<std::uint32_t>(geometry.inliers);
  message.template_stamp = stampToRos(geometry.template_stamp);
  message.companion_stamp = stampToRos(geometry.companion_stamp);
  message.distance_ratio = geometry.distance_ratio;
  message.sigma_ratio = geometry.sigma_ratio;
  return message;
}

geometry_msgs::Quaternion yawToMessage(double yaw_rad) {
  geometry_msgs::Quaternion message;
  message.z = std::sin(0.5 * yaw_rad);
  message.w = std::cos(0.5 * yaw_rad);
  return message;
}

geometry_msgs::Pose poseToMessage(const Eigen::Isometry3d& pose) {
  const geometry_msgs::Transform transform = transformToMessage(pose);
  geometry_msgs::Pose message;
  message.position.x = transform.translation.x;
  message.position.y = transform.translation.y;
  message.position.z = transform.translation.z;
  message.orientation = transform.rotation;
  return message;
}

geometry_msgs::Transform transformToMessage(const Eigen::Isometry3d& transform) {
  const Eigen::Quaterniond rotation(transform.linear());
  geometry_msgs::Transform message;
  message.translation.x = transform.translation().x();
  message.translation.y = transform.translation().y();
  message.translation.z = transform.translation().z();
  message.rotation.x = rotation.x();
  message.rotation.y = rotation.y();
  message.rotation.z = rotation.z();
  message.rotation.w = rotation.w();
  return message;
}

}  // namespace ratslam
