/// ratslam_pc: odom and LocalView/Template -> PoseCell/TopologicalAction and PoseCell/State by the pose cells
/// (docs/model.md section 2), and the picture PoseCell/Activity. The two inputs are merged by stamp.
#pragma once

#include <optional>

#include "ratslam/system/pose_cell_stage.h"
#include "ratslam/view/draw_activity.h"
#include "ratslam_ros/ViewTemplate.h"
#include "ratslam_ros/support/lazy_picture.h"
#include "ratslam_ros/support/message_guard.h"
#include "ratslam_ros/support/node_checkpoints.h"
#include "ratslam_ros/support/node_diagnostics.h"
#include "ratslam_ros/support/node_parameters.h"
#include "ratslam_ros/support/odometry_subscriber.h"
#include "ratslam_ros/support/part_commands.h"
#include "ratslam_ros/support/session_watch.h"
#include "ratslam_ros/support/stage_tuning.h"
#include "ratslam_ros/support/stamp_offset.h"
#include "ratslam_ros/support/start_gate.h"

namespace ratslam {

class PoseCellNode {
 public:
  /// @param own  handle of its private names
  /// @throws std::invalid_argument for bad parameters
  PoseCellNode(ros::NodeHandle handle, const ParameterMap& parameters, const ros::NodeHandle& own);

  /// Writes the last checkpoint. To be called when the node ends.
  void finish();

 private:
  void start();
  PartActions actions();
  void onView(const ratslam_ros::ViewTemplate& message);
  void watch();
  void describe(DiagnosticStatus& status);
  /// Publishes the decisions on the views that pass, unless the part is held. @return whether there were any
  bool drain(Passing which = Passing::kReached);
  void publish(const std::vector<PoseCellDecision>& decisions);

  ros::NodeHandle handle_;
  NodeParams params_;
  PoseCellStage stage_;
  NodeCheckpoints checkpoints_;
  PartCommands commands_;
  NumberSession session_;
  SessionWatch local_view_{"the local view", "views"};
  ros::Publisher action_publisher_;
  ros::Publisher state_publisher_;
  LazyPicture picture_;
  ActivityTrail trail_;
  OdometrySubscriber odometry_;
  StreamWatch views_watch_;
  SyncTimeout odometry_timeout_;
  MessageGuard guard_;
  StampOffset offset_;
  NodeDiagnostics diagnostics_;
  StageTuning<PoseCellStage, PoseCellParams> tuning_;
  RateMeter view_rate_, odometry_rate_;
  std::size_t views_ = 0, samples_ = 0;
  bool went_alone_ = false;  ///< odometry goes on without views
  CountedWarning went_on_without_;
  CountedWarning time_went_back_;
  CountedWarning late_;
  CountedWarning died_out_;
  ros::Subscriber view_subscriber_;
  std::optional<StartGate> gate_;
  ros::WallTimer watch_timer_;
  ros::WallTimer diagnostics_timer_;
};

}  // namespace ratslam
