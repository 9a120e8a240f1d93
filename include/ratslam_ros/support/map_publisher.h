/// Publisher of the experience map: topology and marker (latched, at most every map_period), robot pose, scale, path to
/// the goal, map -> odom, and the picture ExperienceMap/Picture.
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

  /// Publishes robot pose, scale and map -> odom for each decision that the map has processed, oldest first, and
  /// publishMapIfDue().
  void publish(const ExperienceMap& map, const std::vector<Stamp>& processed, OdometryFrame& odometry);

  /// Sets the name of the odometry's frame, if messages name another one than the parameters.
  void setOdometryFrame(const std::string& name);

  /// Publishes the robot's pose at the newest decision with its covariance.
  void publishCovariance(const ExperienceMap& map, Stamp stamp);

  /// Publishes map -> odom at the stamps of the odometry between decisions, if the odometry's unit is not the map's: a
  /// constant transform would be wrong by the scale. Each one is published when the next sample has come, because a
  /// decision of the same stamp has precedence.
  /// @param latest  the robot's pose by all odometry so far
  void followOdometry(const StampedPose& latest, OdometryFrame& odometry);

  /// Publishes, once map_period is over, map and marker if the map has changed since the last time, and the picture also
  /// if the robot has moved or somebody has subscribed.
  void publishMapIfDue(const ExperienceMap& map);
  /// Publishes map and marker if the map has changed since the last time.
  void publishMap(const ExperienceMap& map);

  void publishPath(const ExperienceMap& map);

  /// Publishes a map that was loaded, or forgotten, in place of the one before.
  void replaceMap(const ExperienceMap& map);

 private:
  /// What the picture shows: the revision of the map, the stamp of the robot's pose, and the number of viewers.
  using Pictured = std::tuple<std::uint64_t, Stamp, std::uint32_t>;

  std_msgs::Header header() const;
  void send(const ExperienceMap& map);
  void publishPicture(const ExperienceMap& map);
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
  std::optional<StampedPose> ahead_;  ///< the robot's pose after the last decision
  std::optional<std::uint64_t> published_revision_;
  std::optional<Pictured> pictured_;
  ros::WallTime published_at_;
};

}  // namespace ratslam
