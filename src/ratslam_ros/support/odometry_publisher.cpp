#include "ratslam_ros/support/odometry_publisher.h"

#include <nav_msgs/Odometry.h>

#include "ratslam/local_view/local_view_params.h"
#include "ratslam/vision/rigid_transform.h"
#include "ratslam_ros/support/conversions.h"
#include "ratslam_ros/support/node_parameters.h"
#include "ratslam_ros/support/send_queue.h"

namespace ratslam {
namespace {

/// First epoch of this process, far from those of processes with another first stamp.
std::uint32_t epochFrom(Stamp first) {
  return static_cast<std::uint32_t>((static_cast<std::uint64_t>(first) * 0x9E3779B97F4A7C15U) >> 32U);
}

}  // namespace

NodeParams odometryNodeParams(const ParameterMap& parameters) {
  NodeParams params = readParams<NodeParams>(parameters);
  if (params.wait_for_subscribers > 0 && readParams<ViewRecallParams>(parameters).believes()) {
    ++params.wait_for_subscribers;
  }
  if (params.publish_tf && params.base_frame == params.odomFrame()) {
    throwBadValue("base_frame", "'" + params.base_frame + "'",
                  "it must be another frame than the odometry's, which odom_frame names");
  }
  return params;
}

OdometryPublisher::OdometryPublisher(ros::NodeHandle& handle, const NodeParams& params)
    : params_(params),
      quality_publisher_(handle.advertise<ratslam_ros::OdometryQuality>(
          handle.resolveName(topicName(params.topic_root, "odom")) + "_quality", kSendQueue)),
      publisher_(handle.advertise<nav_msgs::Odometry>(topicName(params.topic_root, "odom"), kSendQueue)) {}

void OdometryPublisher::save(State& state) const {
  state.set("last_stamp", last_stamp_);
  state.set("first_epoch", first_epoch_);
  state.set("pose_covariance", pose_covariance_);
  state.set("last_position", last_position_);
}

void OdometryPublisher::load(const State& state) {
  state.get("last_stamp", last_stamp_);
  state.get("first_epoch", first_epoch_);
  state.get("pose_covariance", pose_covariance_);
  state.get("last_position", last_position_);
}

/// Adds the covariance of a step, in the axes of base_link, to that of the pose, in the axes of the odometry's frame:
/// P <- F P F^T + G Q G^T. F carries the error of the heading over to the position, G turns the axes.
void OdometryPublisher::addToPose(const Eigen::Isometry3d& pose, const TwistCovariance& of_step) {
  const Eigen::Vector3d way = pose.translation() - last_position_.value_or(pose.translation());
  last_position_ = pose.translation();
  TwistCovariance carried = TwistCovariance::Identity();
  carried.topRightCorner<3, 3>() = -skew(way);
  TwistCovariance turned = TwistCovariance::Zero();
  turned.topLeftCorner<3, 3>() = pose.linear();
  turned.bottomRightCorner<3, 3>() = pose.linear();
  pose_covariance_ = carried * pose_covariance_ * carried.transpose() + turned * of_step * turned.transpose();
}

void OdometryPublisher::publish(OdometrySample sample, const Twist& twist) {
  if (!last_stamp_) {
    first_epoch_ = epochFrom(sample.stamp);
    sample.bridged = true;  // the motion before it was not measured
    sample.covariance.reset();
  }
  sample.epoch += first_epoch_;
  const double dt = last_stamp_ ? std::max(0.0, secondsBetween(*last_stamp_, sample.stamp)) : 0.0;
  const bool moved_on = !last_stamp_ || sample.stamp != *last_stamp_;
  last_stamp_ = sample.stamp;
  const TwistCovariance covariance = sample.covariance.value_or(TwistCovariance::Zero());
  addToPose(*sample.pose, dt * dt * covariance);

  quality_publisher_.publish(qualityToMessage(sample));
  nav_msgs::Odometry message;
  message.header.stamp = stampToRos(sample.stamp);
  message.header.frame_id = params_.odomFrame();
  message.child_frame_id = params_.base_frame;
  message.pose.pose = poseToMessage(*sample.pose);
  message.twist.twist.linear.x = sample.speed;
  message.twist.twist.linear.y = twist(1);
  message.twist.twist.linear.z = twist(2);
  message.twist.twist.angular.x = twist(3);
  message.twist.twist.angular.y = twist(4);
  message.twist.twist.angular.z = sample.yaw_rate;
  TwistCovariance::Map(message.twist.covariance.data()) = covariance;
  TwistCovariance::Map(message.pose.covariance.data()) = pose_covariance_;
  publisher_.publish(message);

  if (!params_.publish_tf || !moved_on) return;
  geometry_msgs::TransformStamped transform;
  transform.header = message.header;
  transform.child_frame_id = params_.base_frame;
  transform.transform = transformToMessage(*sample.pose);
  broadcaster_.sendTransform(transform);
}

}  // namespace ratslam
