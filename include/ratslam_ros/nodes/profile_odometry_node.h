/// ratslam_vo: camera/image -> odom by intensity profiles (docs/model.md section 4).
#pragma once

#include <optional>

#include "ratslam/odometry/profile/profile_source.h"
#include "ratslam_ros/support/image_subscriber.h"
#include "ratslam_ros/support/node_diagnostics.h"
#include "ratslam_ros/support/node_parameters.h"
#include "ratslam_ros/support/odometry_checkpoints.h"
#include "ratslam_ros/support/odometry_publisher.h"
#include "ratslam_ros/support/start_gate.h"

namespace ratslam {

class ProfileOdometryNode {
 public:
  /// @param own  handle of its private names
  /// @throws std::invalid_argument for bad parameters
  ProfileOdometryNode(ros::NodeHandle handle, const ParameterMap& parameters, const ros::NodeHandle& own);

  /// Writes the last checkpoint. To be called when the node ends.
  void finish() { checkpoints_.finish(); }

 private:
  void onImage(const std_msgs::Header& header, const ImageFrame& frame);

  NodeParams params_;
  ProfileOdometryParams odometry_params_;
  ProfileSource source_;
  OdometryPublisher publisher_;
  ImageSubscriber images_;
  OdometryCheckpoints checkpoints_;
  NodeDiagnostics diagnostics_;
  std::optional<StartGate> gate_;
  ros::WallTimer watch_timer_;
};

}  // namespace ratslam
