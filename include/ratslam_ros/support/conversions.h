/// Conversions between messages and the types of the core: free functions without state.
///
/// Stamps are exact (nanoseconds). Angles are in radians, counter-clockwise positive, lengths in metres (REP-103).
#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>
#include <nav_msgs/Odometry.h>
#include <ros/time.h>

#include "ratslam/common/pose2.h"
#include "ratslam/events.h"
#include "ratslam/odometry/odometry.h"
#include "ratslam/system/parameter_changes.h"
#include "ratslam/system/pose_cell_stage.h"
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

/// Takes forward speed and yaw rate from the twist; the pose, unless its quaternion is zero, as publishers of twists
/// alone leave it; and the twist's covariance, unless it is all zeros. Values are not checked: they may be not finite.
OdometrySample odometryFromMessage(const nav_msgs::Odometry& message);

/// The quality of a sample, beyond nav_msgs/Odometry.
ratslam_ros::OdometryQuality qualityToMessage(const OdometrySample& sample);
/// @throws std::runtime_error if a number is not finite, or correction_way and its stamps have different lengths
void requireUsable(const ratslam_ros::OdometryQuality& message);
/// Adds the quality of a usable message to a sample.
void addQuality(const ratslam_ros::OdometryQuality& message, OdometrySample& sample);

ViewEvent viewFromMessage(const ratslam_ros::ViewTemplate& message);
ratslam_ros::ViewTemplate viewToMessage(const ViewEvent& view);

/// ViewTemplate has no field for the session, so it is appended to frame_id: "FRAME session ID KNOWN".
std::string withSession(const std::string& frame_id, const NumberSession& session);
/// The session in such a frame_id; id 0 if there is none.
NumberSession sessionIn(const std::string& frame_id);

/// @throws std::runtime_error for an action number that the message type does not define
TopologicalAction actionFromMessage(const ratslam_ros::TopologicalAction& message);
ratslam_ros::TopologicalAction actionToMessage(const TopologicalAction& action);
ratslam_ros::PoseCellState decisionToMessage(const PoseCellDecision& decision, const NumberSession& session);

/// The decision inside a state message, kNone included.
/// @throws std::runtime_error for an action number that the message type does not define
TopologicalAction actionFromMessage(const ratslam_ros::PoseCellState& message);

RecallGeometry geometryFromMessage(const ratslam_ros::RecallGeometry& message);
ratslam_ros::RecallGeometry geometryToMessage(const RecallGeometry& geometry);

/// @throws std::runtime_error if the value is not a number, or the parameter may not change while the nodes run
ParameterChange changeFromMessage(const ratslam_ros::ParameterChange& message);

geometry_msgs::Quaternion yawToMessage(double yaw_rad);
geometry_msgs::Quaternion quaternionToMessage(const Eigen::Quaterniond& rotation);
geometry_msgs::Pose poseToMessage(const Eigen::Isometry3d& pose);
geometry_msgs::Transform transformToMessage(const Eigen::Isometry3d& transform);

}  // namespace ratslam
