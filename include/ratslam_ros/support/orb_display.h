/// Display of ratslam_orb_vo: ~debug_image (features and tracked landmarks) and ~landmarks (the local map as a
/// PointCloud2), both only while they have subscribers, and the odometry's state for the diagnostics.
#pragma once

#include <ros/node_handle.h>
#include <std_msgs/Header.h>

#include <opencv2/core.hpp>
#include <optional>

#include "ratslam/odometry/orb/orb_odometry.h"
#include "ratslam_ros/support/node_diagnostics.h"
#include "ratslam_ros/support/node_params.h"

namespace ratslam {

class OrbDisplay {
 public:
  /// @param own  handle of the node's private names
  OrbDisplay(const NodeParams& params, ros::NodeHandle own);

  /// @param seconds  computing time of this image
  void show(const std_msgs::Header& header, const cv::Mat& image, const CameraModel& camera,
            const OrbOdometry& odometry, const OrbResult& result, double seconds);

  /// The state since the last call. @param odometry  null while there is no calibration
  void describe(DiagnosticStatus& status, const OrbOdometry* odometry);

 private:
  void publishLandmarks(const std_msgs::Header& header, const OrbOdometry& odometry);

  std::string odom_frame_;
  ros::Publisher debug_image_;
  ros::Publisher landmarks_;
  std::optional<OrbResult> last_;
  double slowest_s_ = 0.0;  ///< since the last status
  double summed_s_ = 0.0;
  int images_ = 0;
};

}  // namespace ratslam
