/// What the experience map tells the world: topology and marker (latched, at most every map_period), robot
/// pose, scale, path to the goal, map -> odom, and ExperienceMap/Picture to look at.
#pragma once

#include <ros/node_handle.h>
#include <tf2_ros/transform_broadcaster.h>

#include "ratslam/experience_map/experience_map.h"
#include "ratslam_ros/support/lazy_picture.h"
#include "ratslam_ros/support/node_params.h"
#include "ratslam_ros/support/odometry_frame.h"

namespace ratslam {

class MapPublisher {
 public:
  /// @param with_scale  publish ExperienceMap/Scale
  MapPublisher(ros::NodeHandle& handle, const NodeParams& params, bool with_scale);

  /// Robot pose, scale and map -> odom for each decision that the map has processed, oldest first.
  void publishPoses(const ExperienceMap& map, const std::vector<Stamp>& processed, OdometryFrame& odometry);

  /// Name of the odometry's frame, where messages have told another than the parameters.
  void setOdometryFrame(const std::string& name) { odometry_frame_ = name; }

  /// The robot's pose at the newest decision and how well it is known.
  void publishCovariance(const ExperienceMap& map, Stamp stamp);

  /// map -> odom at the stamps of the odometry between decisions, where the odometry's unit is not the map's: a
  /// transform that stayed would be wrong by the scale. Each is published when the next sample has come, since
  /// a decision of the same stamp knows better.
  /// @param latest  where the robot is by all odometry so far
  void followOdometry(const StampedPose& latest, OdometryFrame& odometry);

  /// Map, marker and picture where the map has changed since they were published and map_period is over.
  void publishMapIfDue(const ExperienceMap& map);
  /// Map and marker where the map has changed since they were published.
  void publishMap(const ExperienceMap& map);

  void publishPath(const ExperienceMap& map);

 private:
  std_msgs::Header header() const;
  void publishTransform(const StampedPose& robot, OdometryFrame& odometry);

  NodeParams params_;
  std::string odometry_frame_;
  ros::Publisher map_;
  ros::Publisher marker_;
  ros::Publisher robot_pose_;
  ros::Publisher robot_pose_with_covariance_;
  ros::Publisher path_;
  ros::Publisher scale_;
  LazyPicture picture_;
  tf2_ros::TransformBroadcaster broadcaster_;
  Stamp newest_ = 0;
  std::optional<Stamp> newest_transform_;
  std::optional<StampedPose> ahead_;  ///< of the decisions
  std::optional<std::uint64_t> published_revision_;
  ros::WallTime published_at_;
};

}  // namespace ratslam
