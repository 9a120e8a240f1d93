/// Images for models that need the camera's calibration.
///
/// A calibration in the parameters (camera_fx ...) has precedence. Otherwise the first usable message of
/// camera/camera_info for the size of the images counts. Without any calibration the images wait, and a warning says how
/// to supply one.
#pragma once

#include <sensor_msgs/CameraInfo.h>

#include <functional>
#include <optional>
#include <vector>

#include "ratslam/camera/camera_params.h"
#include "ratslam/common/parameter_map.h"
#include "ratslam_ros/support/image_subscriber.h"

namespace ratslam {

class CalibratedImages {
 public:
  using CameraHandler = std::function<void(const CameraModel&)>;

  /// @param on_camera  receives the calibration once, before the first image; empty: no calibration is needed
  CalibratedImages(const ros::NodeHandle& handle, const ParameterMap& parameters, CameraHandler on_camera,
                   ImageSubscriber::Handler on_image);

  void start();
  const std::string& topic() { return images_.topic(); }
  const ImageSubscriber& subscriber() const { return images_; }
  ImageSubscriber& subscriber() { return images_; }

  /// To be called about every second.
  void warnIfSomethingNeverCame();

 private:
  void onCameraInfo(const sensor_msgs::CameraInfo& message);
  /// Hands on the camera. If the node cannot use it, see failNode. @throws std::invalid_argument for a bad calibration
  void handOn(const CameraModel& camera);
  void onWaitingImage(const RecordedImage& image);
  /// Starts with the first calibration that fits the newest image, if there are both.
  void chooseCamera();
  void sayUnusable(const std::string& why);

  ros::NodeHandle handle_;
  std::optional<CameraModel> configured_;
  CameraHandler on_camera_;
  bool ready_ = false;
  bool failed_ = false;                         ///< the node is useless (failNode)
  std::vector<sensor_msgs::CameraInfo> infos_;  ///< the first message for each size, until the start
  std::optional<RecordedImage> newest_;         ///< newest waiting image
  ImageSubscriber images_;
  StreamWatch camera_info_watch_;
  ros::Subscriber camera_info_subscriber_;
  CountedWarning no_calibration_;
};

}  // namespace ratslam
