/// Where the camera sits on the robot, by tf: base_frame -> the camera's optical frame, looked up once. What it is at is
/// logged as parameters, with which a run without tf is the same.
#pragma once

#include <ros/node_handle.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <functional>
#include <memory>
#include <string>

#include "ratslam/odometry/orb/orb_params.h"
#include "ratslam_ros/support/counted_warning.h"

namespace ratslam {

class CameraMount {
 public:
  /// Calls `known` once `params` has its mount: at once where it names no camera_frame.
  /// @param params  outlives this
  CameraMount(const ros::NodeHandle& handle, const std::string& base_frame, OrbOdometryParams& params,
              std::function<void()> known);

 private:
  void look();

  struct Transforms {
    explicit Transforms(const ros::NodeHandle& handle) : listener(buffer, handle) {}
    tf2_ros::Buffer buffer;
    tf2_ros::TransformListener listener;
  };

  std::string base_frame_;
  OrbOdometryParams& params_;
  std::function<void()> known_;
  std::unique_ptr<Transforms> transforms_;  // clang 14 takes no optional of it
  CountedWarning missing_;
  ros::WallTime since_;
  ros::WallTimer timer_;
};

}  // namespace ratslam
