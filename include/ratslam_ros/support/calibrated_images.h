/// Images for models that need to know their camera.
///
/// A calibration among the parameters (camera_fx ...) comes before camera/camera_info. Without either the
/// images wait, and a warning says how to supply one; the oldest of more than image_queue_size are lost.
#pragma once

#include <sensor_msgs/CameraInfo.h>

#include <deque>
#include <functional>
#include <optional>

#include "ratslam/camera/camera_params.h"
#include "ratslam_ros/support/image_subscriber.h"

namespace ratslam {

class CalibratedImages {
 public:
  using CameraHandler = std::function<void(const CameraModel&)>;

  /// @param on_camera  gets the calibration, once, before the first image; none: no calibration is needed
  CalibratedImages(const ros::NodeHandle& handle, const NodeParams& params, const CameraParams& configured,
                   CameraHandler on_camera, ImageSubscriber::Handler on_image);

  void start();
  const std::string& topic() { return images_.watch().topic(); }

  /// To be called every second or so.
  void warnIfSomethingNeverCame();

 private:
  struct WaitingImage {
    std_msgs::Header header;
    cv::Mat image;
  };

  void onImage(const std_msgs::Header& header, const cv::Mat& image);
  void onCameraInfo(const sensor_msgs::CameraInfo& message);

  ros::NodeHandle handle_;
  std::size_t most_waiting_;
  std::optional<CameraModel> configured_;
  CameraHandler on_camera_;
  ImageSubscriber::Handler on_image_;
  bool ready_ = false;
  ImageSubscriber images_;
  StreamWatch camera_info_watch_;
  ros::Subscriber camera_info_subscriber_;
  std::deque<WaitingImage> waiting_;
  CountedWarning no_calibration_;
  CountedWarning skipped_;
};

}  // namespace ratslam
