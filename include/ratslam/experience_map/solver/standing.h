/// Where the robot stands beside an experience that it has recalled on known ground (pose_graph_map.h): the
/// recall made no frame of its own, so that the robot's place is an offset from the experience's.
///
/// The offset is a Kalman filter's: odometry predicts it, each recall corrects it. The map is taken as exact,
/// for it knows much more than one recall.
#pragma once

#include "ratslam/experience_map/solver/pose_graph.h"
#include "ratslam/experience_map/solver/uncertain_pose.h"

namespace ratslam {

struct Standing {
  bool beside = false;  ///< else the robot's motion began in the frame itself
  RelativePose at;      ///< where it began
  /// Of that, (x, y, facing, log-scale, z) in the axes of the frame [m].
  NodeCovariance covariance = NodeCovariance::Zero();
  /// The way, told by odometry alone, since a recall that nothing has been made of yet: from the node of its
  /// experience, in the map's unit.
  std::uint32_t way_from = 0;
  UncertainPose way;
  /// Logarithm of the odometry's unit now per its unit at the frame.
  double log_unit = 0.0;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("beside", beside);
    fields("at", at);
    fields("covariance", covariance);
    fields("way_from", way_from);
    fields("way", way);
    fields("log_unit", log_unit);
  }
};

/// Where the robot is after odometry, and how well that is known: in the axes of the place, in map metres.
struct Prediction {
  RelativePose pose;
  double log_scale = 0.0;  ///< map metres per metre of odometry
  NodeCovariance covariance = NodeCovariance::Zero();
};

/// The prediction corrected by what a recall says of the pose. @param log_scale  of the place
Standing stand(const Prediction& predicted, const UncertainPose& seen, double log_scale);

/// (x, y, z, yaw) as a recall with these weights knows them.
Eigen::Matrix4d covarianceOf(const Constraint& constraint);

}  // namespace ratslam
