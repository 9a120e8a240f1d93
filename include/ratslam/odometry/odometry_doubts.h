/// Detects odometry that is well formed but that the models would misinterpret. It changes no result.
///
///  - Motion to the side: the models move forward only.
///  - A twist in another unit than the pose (mm/s with m, degrees/s with rad): the map follows the twist, and the pose
///    contradicts it all the time. (A pose that moves much more than the twist counts as a jump, odometry_timeline.h.)
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "ratslam/odometry/odometry.h"

namespace ratslam {

class OdometryDoubts {
 public:
  /// Takes the next sample of an odometry from outside. @return new doubts, each a sentence; each is returned once
  std::vector<std::string> add(const OdometrySample& sample);

 private:
  void addPose(const OdometrySample& sample, double dt);
  std::optional<std::string> twistSideways(const OdometrySample& sample);
  std::optional<std::string> poseSideways();
  std::optional<std::string> anotherUnit();

  std::optional<OdometrySample> last_;
  int moved_ = 0;               ///< samples at which the pose has moved
  double twist_forward_ = 0.0;  ///< ways, without signs [m]
  double twist_left_ = 0.0;
  double pose_forward_ = 0.0;
  double pose_left_ = 0.0;
  double pose_way_ = 0.0;
  double twist_way_ = 0.0;  ///< where there are poses as well [m]
  double twist_turn_ = 0.0;
  double pose_turn_ = 0.0;  ///< [rad]
  bool said_twist_sideways_ = false;
  bool said_pose_sideways_ = false;
  bool said_unit_ = false;
};

}  // namespace ratslam
