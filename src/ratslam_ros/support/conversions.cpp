#include "ratslam_ros/support/conversions.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>

#include "ratslam/common/text_file.h"
#include "ratslam/dataset/csv.h"

namespace ratslam {
namespace {

constexpr Stamp kNanosecondsPerSecond = 1000000000;
constexpr double kNotStated = -1.0;  // for a standard deviation that the odometry does not state

std_msgs::Header headerAt(Stamp stamp) {
  std_msgs::Header header;
  header.stamp = stampToRos(stamp);
  return header;
}

ActionKind actionKind(std::uint32_t number) {
  if (number > static_cast<std::uint32_t>(ActionKind::kSetNode)) {
    throw std::runtime_error("action " + std::to_string(number) +
                             " is unknown: it must be 1 (create node), 2 (create edge) or 3 (set node)");
  }
  return static_cast<ActionKind>(number);
}

/// The pose; none if its quaternion is zero.
std::optional<Eigen::Isometry3d> poseFromMessage(const geometry_msgs::Pose& message) {
  const Eigen::Quaterniond orientation(message.orientation.w, message.orientation.x, message.orientation.y,
                                       message.orientation.z);
  if (orientation.squaredNorm() == 0.0) return std::nullopt;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = orientation.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(message.position.x, message.position.y, message.position.z);
  return pose;
}

void requireFinite(const char* what, double value) {
  if (!std::isfinite(value)) throw std::runtime_error(std::string(what) + " is not finite");
}

/// The decision in either message; both have the same names of fields.
template <class Message>
TopologicalAction decisionIn(const Message& message) {
  TopologicalAction action;
  action.stamp = stampFromRos(message.header.stamp);
  action.kind = actionKind(message.action);
  action.src_id = message.src_id;
  action.dest_id = message.dest_id;
  action.relative_rad = message.relative_rad;
  requireFinite("relative_rad", action.relative_rad);
  return action;
}

/// Separates frame and session in the frame_id of LocalView/Template.
constexpr char kSessionMark[] = " session ";

}  // namespace

Stamp stampFromRos(const ros::Time& time) { return kNanosecondsPerSecond * time.sec + time.nsec; }

ros::Time stampToRos(Stamp stamp) {
  if (stamp < 0 || stamp / kNanosecondsPerSecond > std::numeric_limits<std::uint32_t>::max()) {
    throw std::runtime_error("the stamp " + std::to_string(stamp) + " ns is outside the range of ROS time");
  }
  return {static_cast<std::uint32_t>(stamp / kNanosecondsPerSecond),
          static_cast<std::uint32_t>(stamp % kNanosecondsPerSecond)};
}

OdometrySample odometryFromMessage(const nav_msgs::Odometry& message) {
  OdometrySample sample;
  sample.stamp = stampFromRos(message.header.stamp);
  sample.speed = message.twist.twist.linear.x;
  sample.yaw_rate = message.twist.twist.angular.z;
  sample.sideways = message.twist.twist.linear.y;
  sample.pose = poseFromMessage(message.pose.pose);
  const TwistCovariance covariance = TwistCovariance::Map(message.twist.covariance.data());
  if (!(covariance.array() == 0.0).all()) sample.covariance = covariance;
  return sample;
}

ratslam_ros::OdometryQuality qualityToMessage(const OdometrySample& sample) {
  ratslam_ros::OdometryQuality message;
  message.header = headerAt(sample.stamp);
  message.epoch = sample.epoch;
  message.bridged = sample.bridged ? 1 : 0;
  message.unit_anchor_sigma = sample.unit ? sample.unit->anchor_sigma.value_or(kNotStated) : kNotStated;
  message.unit_walk_sigma = sample.unit ? sample.unit->walk_sigma : kNotStated;
  message.unit_constant_sigma = sample.unit ? sample.unit->constant_sigma : kNotStated;
  message.has_correction = sample.correction ? 1 : 0;
  message.correction_motion.orientation.w = 1.0;
  if (sample.correction) {
    message.correction_from = stampToRos(sample.correction->from);
    message.correction_to = stampToRos(sample.correction->to);
    message.correction_motion = poseToMessage(sample.correction->motion);
    TwistCovariance::Map(message.correction_covariance.data()) = sample.correction->covariance;
    for (const StampedMotion& moved : sample.correction->way) {
      message.correction_way_stamps.push_back(stampToRos(moved.stamp));
      message.correction_way.push_back(poseToMessage(moved.motion));
    }
  }
  return message;
}

void requireUsable(const ratslam_ros::OdometryQuality& message) {
  requireFinite("unit_walk_sigma", message.unit_walk_sigma);
  requireFinite("unit_anchor_sigma", message.unit_anchor_sigma);
  requireFinite("unit_constant_sigma", message.unit_constant_sigma);
  if (message.has_correction == 0) return;
  const auto require_pose = [](const char* what, const geometry_msgs::Pose& pose) {
    for (const double value : {pose.position.x, pose.position.y, pose.position.z, pose.orientation.x,
                               pose.orientation.y, pose.orientation.z, pose.orientation.w}) {
      requireFinite(what, value);
    }
  };
  require_pose("correction_motion", message.correction_motion);
  for (const geometry_msgs::Pose& pose : message.correction_way) require_pose("correction_way", pose);
  for (const double value : message.correction_covariance) requireFinite("correction_covariance", value);
  if (message.correction_way.size() != message.correction_way_stamps.size()) {
    throw std::runtime_error("correction_way has " + std::to_string(message.correction_way.size()) +
                             " poses and " + std::to_string(message.correction_way_stamps.size()) +
                             " stamps");
  }
}

void addQuality(const ratslam_ros::OdometryQuality& message, OdometrySample& sample) {
  sample.epoch = message.epoch;
  sample.bridged = message.bridged != 0;
  if (message.unit_walk_sigma >= 0.0) {
    sample.unit.emplace();
    sample.unit->walk_sigma = message.unit_walk_sigma;
    if (message.unit_anchor_sigma >= 0.0) sample.unit->anchor_sigma = message.unit_anchor_sigma;
    sample.unit->constant_sigma = std::max(message.unit_constant_sigma, 0.0);
  }
  if (message.has_correction == 0) return;
  OdometryCorrection correction;
  correction.from = stampFromRos(message.correction_from);
  correction.to = stampFromRos(message.correction_to);
  correction.motion = poseFromMessage(message.correction_motion).value_or(Eigen::Isometry3d::Identity());
  correction.covariance = TwistCovariance::Map(message.correction_covariance.data());
  for (std::size_t i = 0; i < message.correction_way.size(); ++i) {
    correction.way.push_back(
        {stampFromRos(message.correction_way_stamps[i]),
         poseFromMessage(message.correction_way[i]).value_or(Eigen::Isometry3d::Identity())});
  }
  sample.correction = correction;
}

ViewEvent viewFromMessage(const ratslam_ros::ViewTemplate& message) {
  ViewEvent view;
  view.stamp = stampFromRos(message.header.stamp);
  view.id = message.current_id;
  view.relative_rad = message.relative_rad;
  requireFinite("relative_rad", view.relative_rad);
  view.session = sessionIn(message.header.frame_id);
  return view;
}

ratslam_ros::ViewTemplate viewToMessage(const ViewEvent& view) {
  ratslam_ros::ViewTemplate message;
  message.header = headerAt(view.stamp);
  message.current_id = view.id;
  message.relative_rad = view.relative_rad;
  return message;
}

TopologicalAction actionFromMessage(const ratslam_ros::TopologicalAction& message) {
  return decisionIn(message);
}

TopologicalAction actionFromMessage(const ratslam_ros::PoseCellState& message) {
  TopologicalAction action = decisionIn(message);
  action.session = {stampFromRos(message.session), message.session_known};
  return action;
}

std::string withSession(const std::string& frame_id, const NumberSession& session) {
  return frame_id + kSessionMark + std::to_string(session.id) + ' ' + std::to_string(session.known);
}

NumberSession sessionIn(const std::string& frame_id) {
  NumberSession session;
  const std::size_t mark = frame_id.rfind(kSessionMark);
  if (mark == std::string::npos) return session;
  std::istringstream text(frame_id.substr(mark + std::strlen(kSessionMark)));
  if (!(text >> session.id >> session.known)) return {};
  return session;
}

ratslam_ros::TopologicalAction actionToMessage(const TopologicalAction& action) {
  ratslam_ros::TopologicalAction message;
  message.header = headerAt(action.stamp);
  message.action = static_cast<std::uint32_t>(action.kind);
  message.src_id = action.src_id;
  message.dest_id = action.dest_id;
  message.relative_rad = action.relative_rad;
  return message;
}

ratslam_ros::PoseCellState decisionToMessage(const PoseCellDecision& decision, const NumberSession& session) {
  const ratslam_ros::TopologicalAction action = actionToMessage(decision.action);
  ratslam_ros::PoseCellState state;
  state.header = action.header;
  state.view_id = decision.view.id;
  state.x = decision.estimate.x;
  state.y = decision.estimate.y;
  state.th = decision.estimate.th;
  state.action = action.action;
  state.src_id = action.src_id;
  state.dest_id = action.dest_id;
  state.relative_rad = action.relative_rad;
  state.session = stampToRos(session.id);
  state.session_known = session.known;
  return state;
}

RecallGeometry geometryFromMessage(const ratslam_ros::RecallGeometry& message) {
  RecallGeometry geometry;
  geometry.stamp = stampFromRos(message.header.stamp);
  geometry.view_id = message.view_id;
  geometry.relative_rad = message.relative_rad;
  geometry.direction_rad = message.direction_rad;
  geometry.distance = message.distance;
  geometry.sigma_distance = message.sigma_distance;
  geometry.sigma_rotation = message.sigma_rotation;
  geometry.sigma_direction = message.sigma_direction;
  geometry.inliers = static_cast<int>(message.inliers);
  geometry.template_stamp = stampFromRos(message.template_stamp);
  geometry.companion_stamp = stampFromRos(message.companion_stamp);
  geometry.distance_ratio = message.distance_ratio;
  geometry.sigma_ratio = message.sigma_ratio;
  geometry.ahead = message.ahead;
  requireFinite("ahead of a recall's geometry", geometry.ahead);
  if (geometry.inliers > 0) {
    for (const double value :
         {geometry.relative_rad, geometry.direction_rad, geometry.distance, geometry.sigma_distance,
          geometry.sigma_rotation, geometry.sigma_direction, geometry.distance_ratio, geometry.sigma_ratio}) {
      requireFinite("a measurement of the recall's geometry", value);
    }
  }
  return geometry;
}

ratslam_ros::RecallGeometry geometryToMessage(const RecallGeometry& geometry) {
  ratslam_ros::RecallGeometry message;
  message.header = headerAt(geometry.stamp);
  message.view_id = geometry.view_id;
  message.relative_rad = geometry.relative_rad;
  message.direction_rad = geometry.direction_rad;
  message.distance = geometry.distance;
  message.sigma_distance = geometry.sigma_distance;
  message.sigma_rotation = geometry.sigma_rotation;
  message.sigma_direction = geometry.sigma_direction;
  message.inliers = static_cast<std::uint32_t>(geometry.inliers);
  message.template_stamp = stampToRos(geometry.template_stamp);
  message.companion_stamp = stampToRos(geometry.companion_stamp);
  message.distance_ratio = geometry.distance_ratio;
  message.sigma_ratio = geometry.sigma_ratio;
  message.ahead = geometry.ahead;
  return message;
}

ParameterChange changeFromMessage(const ratslam_ros::ParameterChange& message) {
  double number = 0.0;
  if (!isChangeable(message.name) || !parseNumber(message.value, number)) {
    throw std::runtime_error("'" + shown(message.name) + " = " + shown(message.value) +
                             "' is no number for a parameter that can change in the middle of a drive");
  }
  return {stampFromRos(message.header.stamp), message.name, message.value, ""};
}

geometry_msgs::Quaternion yawToMessage(double yaw_rad) {
  geometry_msgs::Quaternion message;
  message.z = std::sin(0.5 * yaw_rad);
  message.w = std::cos(0.5 * yaw_rad);
  return message;
}

geometry_msgs::Pose poseToMessage(const Eigen::Isometry3d& pose) {
  const geometry_msgs::Transform transform = transformToMessage(pose);
  geometry_msgs::Pose message;
  message.position.x = transform.translation.x;
  message.position.y = transform.translation.y;
  message.position.z = transform.translation.z;
  message.orientation = transform.rotation;
  return message;
}

geometry_msgs::Quaternion quaternionToMessage(const Eigen::Quaterniond& rotation) {
  geometry_msgs::Quaternion message;
  message.x = rotation.x();
  message.y = rotation.y();
  message.z = rotation.z();
  message.w = rotation.w();
  return message;
}

geometry_msgs::Transform transformToMessage(const Eigen::Isometry3d& transform) {
  geometry_msgs::Transform message;
  message.translation.x = transform.translation().x();
  message.translation.y = transform.translation().y();
  message.translation.z = transform.translation().z();
  message.rotation = quaternionToMessage(Eigen::Quaterniond(transform.linear()));
  return message;
}

}  // namespace ratslam
