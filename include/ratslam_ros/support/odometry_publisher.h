/// Publisher of one of our odometries: nav_msgs/Odometry, its quality on the same name with _quality, and, on request, odom ->
/// base_link (REP-105).
///
/// odom_quality is advertised before odom, and the quality of a sample is published before the sample. So a subscriber
/// knows whether to wait for the quality of a sample.
///
/// Each process has its own range of epochs. So subscribers notice at the first sample of a restarted process that the
/// motion before it was not measured.
#pragma once

#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "ratslam/common/parameter_map.h"
#include "ratslam/common/state.h"
#include "ratslam/odometry/odometry.h"
#include "ratslam_ros/support/node_params.h"

namespace ratslam {

/// (vx, vy, vz, wx, wy, wz) in base_link [m/s, rad/s].
using Twist = Eigen::Matrix<double, 6, 1>;

/// The parameters of an odometry's node. It waits for the subscribers of the launch file: pose cells, map, and with
/// vt_recall belief the local view.
/// @throws std::invalid_argument for bad parameters
NodeParams odometryNodeParams(const ParameterMap& parameters);

class OdometryPublisher {
 public:
  OdometryPublisher(ros::NodeHandle& handle, const NodeParams& params);

  /// @param sample  with the stamp of its image; must have a pose
  /// @param twist   all six components; speed, yaw rate and covariance are taken from the sample
  /// The pose's covariance is that of all steps, to first order, in the axes of header.frame_id. A step without a
  /// covariance (a bridged one) adds nothing.
  void publish(OdometrySample sample, const Twist& twist);

  std::optional<Stamp> lastStamp() const { return last_stamp_; }
  /// Treats the next sample like the first one of a process.
  void beginAnew() { last_stamp_.reset(); }
  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing
  void load(const State& state);

  std::vector<ros::Publisher> publishers() const { return {quality_publisher_, publisher_}; }

 private:
  void addToPose(const Eigen::Isometry3d& pose, const TwistCovariance& of_step);

  NodeParams params_;
  ros::Publisher quality_publisher_;
  ros::Publisher publisher_;
  tf2_ros::TransformBroadcaster broadcaster_;
  std::optional<Stamp> last_stamp_;
  std::uint32_t first_epoch_ = 0;
  TwistCovariance pose_covariance_ = TwistCovariance::Zero();
  std::optional<Eigen::Vector3d> last_position_;
};

}  // namespace ratslam
