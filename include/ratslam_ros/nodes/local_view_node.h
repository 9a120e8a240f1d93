/// ratslam_lv: camera/image -> LocalView/Template by the local view cells (docs/model.md section 1), and the picture
/// LocalView/View. With vt_recall belief it also subscribes to odom, which is merged with the images by stamp. With
/// vt_verify orb it also subscribes to camera/camera_info. With either it publishes LocalView/RecallGeometry, one
/// message per image.
#pragma once

#include <optional>

#include "ratslam/system/local_view_stage.h"
#include "ratslam_ros/support/calibrated_images.h"
#include "ratslam_ros/support/lazy_picture.h"
#include "ratslam_ros/support/message_guard.h"
#include "ratslam_ros/support/node_checkpoints.h"
#include "ratslam_ros/support/node_diagnostics.h"
#include "ratslam_ros/support/node_parameters.h"
#include "ratslam_ros/support/odometry_subscriber.h"
#include "ratslam_ros/support/part_commands.h"
#include "ratslam_ros/support/stage_tuning.h"
#include "ratslam_ros/support/start_gate.h"

namespace ratslam {

class LocalViewNode {
 public:
  /// @param own  handle of its private names
  /// @throws std::invalid_argument for bad parameters
  LocalViewNode(ros::NodeHandle handle, const ParameterMap& parameters, const ros::NodeHandle& own);

  /// Writes the last checkpoint. To be called when the node ends.
  void finish();

 private:
  CalibratedImages::CameraHandler cameraHandler();
  void start();
  void resume();
  PartActions actions();
  void onImage(const std_msgs::Header& header, const ImageFrame& frame);
  void watch();
  /// Publishes the views that pass, unless the part is held. @return whether there were any
  bool drain(Passing which = Passing::kReached);
  void publish(const std::vector<ViewObservation>& observations);

  ros::NodeHandle handle_;
  NodeParams params_;
  LocalViewStage stage_;
  NodeCheckpoints checkpoints_;
  PartCommands commands_;
  NumberSession session_;
  std::vector<ros::Publisher> outputs_;  ///< templates and, if there is any, recall geometry
  LazyPicture picture_;
  OdometrySubscriber odometry_;
  SyncTimeout odometry_timeout_;
  CountedWarning went_on_without_;
  MessageGuard guard_;
  std_msgs::Header last_header_;
  cv::Mat last_image_;  ///< for the picture
  CalibratedImages images_;
  NodeDiagnostics diagnostics_;
  StageTuning<LocalViewStage, LocalViewParams> tuning_;
  std::optional<StartGate> gate_;
  ros::WallTimer watch_timer_;
  ros::WallTimer diagnostics_timer_;
};

}  // namespace ratslam
