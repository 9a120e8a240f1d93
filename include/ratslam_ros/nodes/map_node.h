/// ratslam_em: odom and the decisions of the pose cells -> experience map, robot pose, map -> odom, trajectories, path
/// to a goal (docs/model.md section 3). The streams are merged by stamp.
#pragma once

#include <geometry_msgs/PoseStamped.h>

#include <optional>

#include "ratslam/system/map_stage.h"
#include "ratslam_ros/RecallGeometry.h"
#include "ratslam_ros/support/change_log.h"
#include "ratslam_ros/support/decision_reports.h"
#include "ratslam_ros/support/decision_source.h"
#include "ratslam_ros/support/goal_reporter.h"
#include "ratslam_ros/support/map_publisher.h"
#include "ratslam_ros/support/map_services.h"
#include "ratslam_ros/support/message_guard.h"
#include "ratslam_ros/support/node_checkpoints.h"
#include "ratslam_ros/support/node_diagnostics.h"
#include "ratslam_ros/support/node_parameters.h"
#include "ratslam_ros/support/odometry_subscriber.h"
#include "ratslam_ros/support/rival_watch.h"
#include "ratslam_ros/support/session_watch.h"
#include "ratslam_ros/support/stage_tuning.h"

namespace ratslam {

class MapNode {
 public:
  /// @param own  handle of its private names
  /// @throws std::invalid_argument for bad parameters
  MapNode(const ros::NodeHandle& handle, const ParameterMap& parameters, const ros::NodeHandle& own);

  /// Publishes the map a last time and writes the trajectories. To be called when the node ends.
  void finish();

 private:
  void subscribe();
  template <class Message>
  void onDecision(const Message& message);
  PartActions actions();
  bool isEmpty() const { return stage_.map().graph().experiences().empty(); }
  /// @return names of the files
  std::string write(const std::string& file, const ExperienceMap& map);
  /// See MapServices.
  std::string behind(const StreamPoint& last, Stamp last_change, bool all) const;
  void watch();
  /// Processes the decisions that pass, and publishes.
  void drain(Passing which);

  ros::NodeHandle handle_;
  NodeParams params_;
  GeometrySource geometry_;  ///< source of the decisions' RecallGeometry
  MapStage stage_;
  NodeCheckpoints checkpoints_;
  PartCommands commands_;
  SessionWatch pose_cells_{"the pose cells", "experiences"};
  MapPublisher publisher_;
  OdometryFrame odometry_frame_;
  OdometrySubscriber odometry_;
  StreamWatch decisions_watch_;
  DecisionSource source_;
  SyncTimeout silence_;
  GoalReporter goals_;
  MessageGuard guard_;
  DecisionReports reports_;
  CountedWarning went_on_without_;
  std::vector<ros::Subscriber> subscribers_;
  MapServices services_;
  RivalWatch rivals_;
  NodeDiagnostics diagnostics_;
  ChangeLog changes_;
  StageTuning<MapStage, ExperienceMapParams> tuning_;
  ros::WallTimer watch_timer_;
  ros::WallTimer diagnostics_timer_;
};

}  // namespace ratslam
