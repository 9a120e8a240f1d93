/// Messages to and from the types of the core, one function each way, no state.
///
/// Stamps are copied whole (nanoseconds); angles are radians, counter-clockwise positive, lengths metres
/// (REP-103).
#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>
#include <nav_msgs/Odometry.h>
#include <ros/time.h>

#include "ratslam/common/pose2.h"
#include "ratslam/events.h"
#include "ratslam/odometry/odometry.h"
#include "ratslam/system/parameter_changes.h"
#include "ratslam_ros/OdometryQuality.h"
#include "ratslam_ros/ParameterChange.h"
#include "ratslam_ros/PoseCellState.h"
#include "ratslam_ros/RecallGeometry.h"
#include "ratslam_ros/TopologicalAction.h"
#include "ratslam_ros/ViewTemplate.h"

namespace ratslam {

Stamp stampFromRos(const ros::Time& time);

/// @throws std::runtime_error for stamps that ROS cannot carry (negative, or after 2106)
ros::Time stampToRos(Stamp stamp);

/// Forward speed and yaw rate from the twist; the pose where the message has one (a quaternion of zeros is
/// how publishers of mere twists leave it); the twist's covariance, of which all zeros say nothing. Values are
/// taken as they are, not finite ones included.
OdometrySample odometryFromMessage(const nav_msgs::Odometry& message);

/// What a sample says of itself beyond nav_msgs/Odometry.
ratslam_ros::OdometryQuality qualityToMessage(const OdometrySample& sample);
/// @throws std::runtime_error where a number is not finite or the correction's way has poses without stamps
void requireUsable(const ratslam_ros::OdometryQuality& message);
/// Fills in what a usable message says.
void addQuality(const ratslam_ros::OdometryQuality& message, OdometrySample& sample);

ViewEvent viewFromMessage(const ratslam_ros::ViewTemplate& message);
ratslam_ros::ViewTemplate viewToMessage(const ViewEvent& view);

/// The fields of ViewTemplate are OpenRatSLAM's: the session of the views' numbers follows the frame's name.
std::string withSession(const std::string& frame_id, const NumberSession& session);
/// The session in such a frame_id; id 0 where there is none.
NumberSession sessionIn(const std::string& frame_id);

/// @throws std::runtime_error for an action that is none of those of the message
TopologicalAction actionFromMessage(const ratslam_ros::TopologicalAction& message);
ratslam_ros::TopologicalAction actionToMessage(const TopologicalAction& action);

/// The decision inside a state message, kNone included.
/// @throws std::runtime_error for an action that is none of those of the message
TopologicalAction actionFromMessage(const ratslam_ros::PoseCellState& message);

RecallGeometry geometryFromMessage(const ratslam_ros::RecallGeometry& message);
ratslam_ros::RecallGeometry geometryToMessage(const RecallGeometry& geometry);

/// @throws std::runtime_error where it is no number, or for a parameter that cannot change
ParameterChange changeFromMessage(const ratslam_ros::ParameterChange& message);

geometry_msgs::Quaternion yawToMessage(double yaw_rad);
geometry_msgs::Quaternion quaternionToMessage(const Eigen::Quaterniond& rotation);
geometry_msgs::Pose poseToMessage(const Eigen::Isometry3d& pose);
geometry_msgs::Transform transformToMessage(const Eigen::Isometry3d& transform);

}  // namespace ratslam
