/// ratslam_em: odom and the decisions of the pose cells -> experience map, robot pose, map -> odom,
/// trajectories, path to a goal (docs/model.md section 3), the streams merged by stamp.
#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <std_srvs/Trigger.h>

#include <optional>

#include "ratslam/local_view/recall/recall_geometry_params.h"
#include "ratslam/system/map_stage.h"
#include "ratslam_ros/RecallGeometry.h"
#include "ratslam_ros/support/change_log.h"
#include "ratslam_ros/support/decision_source.h"
#include "ratslam_ros/support/goal_reporter.h"
#include "ratslam_ros/support/map_publisher.h"
#include "ratslam_ros/support/message_guard.h"
#include "ratslam_ros/support/node_checkpoints.h"
#include "ratslam_ros/support/node_diagnostics.h"
#include "ratslam_ros/support/node_parameters.h"
#include "ratslam_ros/support/odometry_subscriber.h"
#include "ratslam_ros/support/rival_watch.h"
#include "ratslam_ros/support/stage_tuning.h"
#include "ratslam_ros/support/trajectory_files.h"

namespace ratslam {

class MapNode {
 public:
  /// @param own  handle of its private names
  /// @throws std::invalid_argument for bad parameters
  MapNode(const ros::NodeHandle& handle, const ParameterMap& parameters, const ros::NodeHandle& own);

  /// Publishes the map a last time and writes the trajectories; to be called when the node ends.
  void finish();

 private:
  void subscribe();
  template <class Message>
  void onDecision(const Message& message);
  bool onWriteTrajectories(std_srvs::TriggerRequest&, std_srvs::TriggerResponse& response);
  TrajectoryFiles writeFiles() const;
  void watch();
  /// Processes what is possible, without waiting for silent streams where `wait` is false; publishes.
  void drain(bool wait);

  ros::NodeHandle handle_;
  NodeParams params_;
  bool verifies_;  ///< decisions come with a RecallGeometry
  MapStage stage_;
  NodeCheckpoints checkpoints_;
  MapPublisher publisher_;
  OdometryFrame odometry_frame_;
  OdometrySubscriber odometry_;
  StreamWatch decisions_watch_;
  DecisionSource source_;
  SyncTimeout silence_;
  GoalReporter goals_;
  MessageGuard guard_;
  CountedWarning bad_decision_;
  CountedWarning recreated_;
  CountedWarning went_on_without_;
  CountedWarning time_went_back_;
  std::vector<ros::Subscriber> subscribers_;
  ros::ServiceServer write_service_;
  RivalWatch rivals_;
  NodeDiagnostics diagnostics_;
  ChangeLog changes_;
  StageTuning<MapStage, ExperienceMapParams> tuning_;
  ros::WallTimer watch_timer_;
  ros::WallTimer diagnostics_timer_;
};

}  // namespace ratslam
