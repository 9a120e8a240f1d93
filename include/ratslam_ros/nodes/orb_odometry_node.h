/// ratslam_orb_vo: camera/image and camera/camera_info -> odom by ORB features.
#pragma once

#include <optional>

#include "ratslam/odometry/orb/orb_source.h"
#include "ratslam_ros/support/calibrated_images.h"
#include "ratslam_ros/support/camera_mount.h"
#include "ratslam_ros/support/node_diagnostics.h"
#include "ratslam_ros/support/node_parameters.h"
#include "ratslam_ros/support/odometry_checkpoints.h"
#include "ratslam_ros/support/odometry_publisher.h"
#include "ratslam_ros/support/orb_display.h"
#include "ratslam_ros/support/start_gate.h"

namespace ratslam {

class OrbOdometryNode {
 public:
  /// @param own  handle of its private names
  /// @throws std::invalid_argument for bad parameters
  OrbOdometryNode(ros::NodeHandle handle, const ParameterMap& parameters, const ros::NodeHandle& own);

  /// Writes the last checkpoint. To be called when the node ends.
  void finish();

 private:
  void onCamera(const CameraModel& camera);
  void onImage(const std_msgs::Header& header, const ImageFrame& frame);
  /// Warns if no image at all could be tracked.
  void sayWhatIsNotTracked() const;

  NodeParams params_;
  OrbOdometryParams odometry_params_;
  ImageStageParams image_params_;
  std::map<std::string, std::string> part_parameters_;  ///< of a checkpoint
  std::optional<OrbSource> source_;                     ///< once the camera is known
  OdometryPublisher publisher_;
  OrbDisplay display_;
  CalibratedImages images_;
  std::optional<OdometryCheckpoints> checkpoints_;  ///< of source_
  NodeDiagnostics diagnostics_;
  CountedWarning restarted_;
  std::size_t seen_ = 0;  ///< images of this process
  std::optional<StartGate> gate_;
  ros::WallTimer watch_timer_;
  std::optional<CameraMount> mount_;
};

}  // namespace ratslam
