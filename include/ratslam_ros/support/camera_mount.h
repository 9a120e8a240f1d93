/// The camera's pose on the robot from tf: base_frame -> the camera's optical frame. It is looked up once, and logged as
/// parameters with which a run without tf is the same.
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
  /// Calls `known` once `params` has the camera's pose: at once if it names no camera_frame.
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
  std::unique_ptr<Transforms> transforms_;  // clang 14 does not compile an optional of it
  CountedWarning missing_;
  ros::WallTime since_;
  ros::WallTimer timer_;
};

}  // namespace ratslam
