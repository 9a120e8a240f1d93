#include "ratslam/odometry/orb/orb_params.h"

#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"

namespace ratslam {
namespace {

/// Axes of a level camera that looks ahead, in base_link.
Eigen::Matrix3d levelCamera() {
  Eigen::Matrix3d level;
  level << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return level;
}

}  // namespace

Eigen::Isometry3d OrbOdometryParams::baseFromCamera() const {
  Eigen::Matrix3d turned =
      Eigen::AngleAxisd(degreesToRadians(camera_pitch_deg), Eigen::Vector3d::UnitY()).toRotationMatrix();
  if (camera_yaw_deg != 0.0) {
    turned = Eigen::AngleAxisd(degreesToRadians(camera_yaw_deg), Eigen::Vector3d::UnitZ()) * turned;
  }
  if (camera_roll_deg != 0.0) {
    turned = turned * Eigen::AngleAxisd(degreesToRadians(camera_roll_deg), Eigen::Vector3d::UnitX());
  }
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = turned * levelCamera();
  T.translation() = Eigen::Vector3d(camera_x, camera_y, camera_z);
  return T;
}

void OrbOdometryParams::setBaseFromCamera(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d turned = T.linear() * levelCamera().transpose();
  camera_yaw_deg = radiansToDegrees(std::atan2(turned(1, 0), turned(0, 0)));
  camera_pitch_deg = radiansToDegrees(std::asin(std::clamp(-turned(2, 0), -1.0, 1.0)));
  camera_roll_deg = radiansToDegrees(std::atan2(turned(2, 1), turned(2, 2)));
  camera_x = T.translation().x();
  camera_y = T.translation().y();
  camera_z = T.translation().z();
}

void OrbOdometryParams::validate() const {
  checkBounds(*this);
  if (fast_min_threshold > fast_threshold) {
    throwBadValue("orb_fast_min_threshold", fast_min_threshold, "it must not exceed orb_fast_threshold");
  }
  if (ground_plane && levels < 2) {
    throwBadValue("orb_levels", levels,
                  "it must be 2 or above: orb_ground_plane measures the road on smaller images");
  }
  if (map_keyframes <= window_keyframes) {
    throwBadValue("orb_map_keyframes", map_keyframes, "it must exceed orb_window_keyframes");
  }
  if (init_points > features) {
    throwBadValue("orb_init_points", init_points, "it must not exceed orb_features, or no map could begin");
  }
  if (!camera_frame.empty() && camera_frame.front() == '/') {
    throwBadValue("camera_frame", "'" + camera_frame + "'",
                  "it must be the name of a tf2 frame, without a leading slash");
  }
}

void OrbOdometryParams::requireNoCameraFrame() const {
  if (camera_frame.empty()) return;
  throwBadValue(
      "camera_frame", camera_frame,
      "there is no tf here; leave it empty and set camera_x ... camera_yaw_deg to what ratslam_orb_vo says "
      "when it has looked them up");
}

}  // namespace ratslam
