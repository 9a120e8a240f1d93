/// Publishes an odometry of ours: nav_msgs/Odometry and, on request, odom -> base_link (REP-105).
#pragma once

#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include <Eigen/Core>
#include <optional>

#include "ratslam/common/odometry.h"
#include "ratslam_ros/node_params.h"

namespace ratslam {

/// Covariance of (vx, vy, vz, wx, wy, wz) in base_link [m^2/s^2, rad^2/s^2], as nav_msgs/Odometry has it.
using TwistCovariance = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

class OdometryPublisher {
 public:
  OdometryPublisher(ros::NodeHandle& handle, const NodeParams& params);

  /// @param sample  stamped with the image it was made of; must have a pose
  /// The pose's covariance is what the twist's variances have added up to.
  void publish(const OdometrySample& sample, const TwistCovariance& covariance);

  const ros::Publisher& publisher() const { return publisher_; }

 private:
  NodeParams params_;
  ros::Publisher publisher_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::optional<Stamp> last_stamp_;
  TwistCovariance pose_covariance_ = TwistCovariance::Zero();
};

}  // namespace ratslam
