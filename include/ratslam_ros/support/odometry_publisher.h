/// Publishes an odometry of ours: nav_msgs/Odometry and, on request, odom -> base_link (REP-105).
#pragma once

#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include <Eigen/Core>
#include <optional>

#include "ratslam/odometry/odometry.h"
#include "ratslam_ros/support/node_params.h"

namespace ratslam {

/// (vx, vy, vz, wx, wy, wz) in base_link [m/s, rad/s].
using Twist = Eigen::Matrix<double, 6, 1>;

class OdometryPublisher {
 public:
  OdometryPublisher(ros::NodeHandle& handle, const NodeParams& params);

  /// @param sample  stamped with the image it was made of; must have a pose
  /// @param twist   all of the motion; speed and yaw rate are taken from the sample
  /// The pose's covariance is what the twist's variances have added up to.
  void publish(const OdometrySample& sample, const Twist& twist, const TwistCovariance& covariance);

  const ros::Publisher& publisher() const { return publisher_; }

 private:
  NodeParams params_;
  ros::Publisher publisher_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::optional<Stamp> last_stamp_;
  TwistCovariance pose_covariance_ = TwistCovariance::Zero();
};

}  // namespace ratslam
