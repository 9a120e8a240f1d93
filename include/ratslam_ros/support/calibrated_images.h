/// Images for models that need to know their camera.
///
/// A calibration among the parameters (camera_fx ...) comes before camera/camera_info, of which the first usable one for
/// images of the size that comes counts. Without either the images wait, and a warning says how to supply one.
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

  /// @param on_camera  gets the calibration, once, before the first image; none: no calibration is needed
  CalibratedImages(const ros::NodeHandle& handle, const ParameterMap& parameters, CameraHandler on_camera,
                   ImageSubscriber::Handler on_image);

  void start();
  const std::string& topic() { return images_.watch().topic(); }
  const ImageSubscriber& subscriber() const { return images_; }
  ImageSubscriber& subscriber() { return images_; }

  /// To be called every second or so.
  void warnIfSomethingNeverCame();

 private:
  void onCameraInfo(const sensor_msgs::CameraInfo& message);
  void onWaitingImage(const RecordedImage& image);
  /// Begins with the first calibration that fits the newest image, where there are both.
  void chooseCamera();
  void sayUnusable(const std::string& why);

  ros::NodeHandle handle_;
  std::optional<CameraModel> configured_;
  CameraHandler on_camera_;
  bool ready_ = false;
  std::vector<sensor_msgs::CameraInfo> infos_;  ///< before it is ready: the first of each size
  std::optional<RecordedImage> newest_;         ///< of the images that wait
  ImageSubscriber images_;
  StreamWatch camera_info_watch_;
  ros::Subscriber camera_info_subscriber_;
  CountedWarning no_calibration_;
};

}  // namespace ratslam
