#include "ratslam_ros/support/camera_mount.h"

#include <ros/console.h>

namespace ratslam {
namespace {

const ros::WallDuration kPollPeriod(0.1);
const ros::WallDuration kPatience(5.0);

}  // namespace

CameraMount::CameraMount(const ros::NodeHandle& handle, const std::string& base_frame,
                         OrbOdometryParams& params, std::function<void()> known)
    : base_frame_(base_frame), params_(params), known_(std::move(known)), since_(ros::WallTime::now()) {
  if (params_.camera_frame.empty()) {
    known_();
    return;
  }
  transforms_ = std::make_unique<Transforms>(handle);
  timer_ = handle.createWallTimer(kPollPeriod, [this](const ros::WallTimerEvent&) { look(); });
}

void CameraMount::look() {
  const std::string ends = base_frame_ + " -> " + params_.camera_frame;
  std::string why;
  if (!transforms_->buffer.canTransform(base_frame_, params_.camera_frame, ros::Time(0), &why)) {
    if (ros::WallTime::now() - since_ < kPatience) return;
    missing_.report("images wait for the transform " + ends +
                    " (camera_frame), which nobody broadcasts: " + why);
    return;
  }
  OrbOdometryParams with_mount = params_;
  const auto found =
      transforms_->buffer.lookupTransform(base_frame_, params_.camera_frame, ros::Time(0)).transform;
  Eigen::Isometry3d mount = Eigen::Isometry3d::Identity();
  mount.linear() = Eigen::Quaterniond(found.rotation.w, found.rotation.x, found.rotation.y, found.rotation.z)
                       .normalized()
                       .toRotationMatrix();
  mount.translation() = Eigen::Vector3d(found.translation.x, found.translation.y, found.translation.z);
  with_mount.setBaseFromCamera(mount);
  try {
    with_mount.validate();
  } catch (const std::invalid_argument& e) {
    missing_.report("the transform " + ends + " (camera_frame) is not usable: " + e.what());
    return;
  }
  timer_.stop();
  params_ = with_mount;
  ROS_INFO(
      "%s by tf: camera_x: %.17g, camera_y: %.17g, camera_z: %.17g, camera_roll_deg: %.17g, "
      "camera_pitch_deg: "
      "%.17g, camera_yaw_deg: %.17g",
      ends.c_str(), params_.camera_x, params_.camera_y, params_.camera_z, params_.camera_roll_deg,
      params_.camera_pitch_deg, params_.camera_yaw_deg);
  known_();
}

}  // namespace ratslam
