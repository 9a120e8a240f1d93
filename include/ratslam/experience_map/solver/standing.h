/// The robot's pose beside an experience that it has recalled on known ground (pose_graph_map.h). Such a recall
/// makes no frame. So the robot's place is stated as an offset from the experience.
///
/// A Kalman filter estimates the offset: odometry predicts it, each recall corrects it. The map counts as exact,
/// because it is known much better than one recall.
#pragma once

#include "ratslam/experience_map/solver/pose_graph.h"
#include "ratslam/experience_map/solver/uncertain_pose.h"

namespace ratslam {

struct Standing {
  bool beside = false;  ///< the robot's motion began beside the frame; false: in the frame
  RelativePose at;      ///< pose in the frame at which the motion began
  /// Covariance of `at` (x, y, facing, log-scale, z) in the axes of the frame [m].
  NodeCovariance covariance = NodeCovariance::Zero();
  /// The present pass (pass_evidence.h): node of the experience at whose recall it began, and the motion since
  /// by odometry alone, in the map's unit.
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

/// The robot's pose predicted by odometry, in the axes of a place, in map metres.
struct Prediction {
  RelativePose pose;
  double log_scale = 0.0;  ///< map metres per metre of odometry
  NodeCovariance covariance = NodeCovariance::Zero();
};

/// Corrects the prediction by the pose that a recall measured (Kalman update). @param log_scale  of the place
Standing stand(const Prediction& predicted, const UncertainPose& seen, double log_scale);

}  // namespace ratslam
