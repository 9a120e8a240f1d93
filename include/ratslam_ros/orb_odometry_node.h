/// ratslam_orb_vo: camera/image and camera/camera_info -> odom by ORB features.
///
/// A calibration among the parameters (camera_fx ...) comes before camera_info. Without either the images
/// wait, and a warning says how to supply one.
#pragma once

#include <sensor_msgs/CameraInfo.h>

#include <deque>
#include <memory>
#include <optional>

#include "ratslam/orb_odometry/camera_params.h"
#include "ratslam/orb_odometry/orb_odometry.h"
#include "ratslam_ros/image_subscriber.h"
#include "ratslam_ros/node_parameters.h"
#include "ratslam_ros/odometry_publisher.h"
#include "ratslam_ros/orb_display.h"
#include "ratslam_ros/start_gate.h"

namespace ratslam {

class OrbOdometryNode {
 public:
  /// @throws std::invalid_argument for bad parameters
  OrbOdometryNode(ros::NodeHandle handle, const ParameterMap& parameters);

 private:
  struct WaitingImage {
    std_msgs::Header header;
    cv::Mat image;
  };

  void start();
  void onCameraInfo(const sensor_msgs::CameraInfo& message);
  void onImage(const std_msgs::Header& header, const cv::Mat& image);
  void track(const std_msgs::Header& header, const cv::Mat& image);
  void useCamera(const CameraModel& camera);

  ros::NodeHandle handle_;
  NodeParams params_;
  OrbOdometryParams odometry_params_;
  std::optional<CameraModel> camera_;
  std::optional<OrbOdometry> odometry_;
  OdometryPublisher publisher_;
  OrbDisplay display_;
  ImageSubscriber images_;
  StreamWatch camera_info_watch_;
  ros::Subscriber camera_info_subscriber_;
  std::deque<WaitingImage> waiting_;
  std::optional<Stamp> last_stamp_;
  CountedWarning no_calibration_;
  CountedWarning repeated_;
  CountedWarning time_went_back_;
  CountedWarning restarted_;
  std::optional<StartGate> gate_;
  ros::WallTimer watch_timer_;
};

}  // namespace ratslam
