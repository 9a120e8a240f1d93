#include "ratslam_ros/support/calibrated_images.h"

#include "ratslam_ros/support/camera_info.h"
#include "ratslam_ros/support/node_parameters.h"

namespace ratslam {
namespace {

const char kHowToCalibrate[] =
    "; publish a calibration there, or set camera_fx, camera_fy, camera_cx, camera_cy, camera_width_px and "
    "camera_height_px (and camera_distortion) in the configuration";

/// Topic of the calibration. Where the images have been remapped and it has not, it lies beside them, as
/// image_transport's camera subscribers have it.
std::string cameraInfoTopic(const ros::NodeHandle& handle, const std::string& images,
                            const std::string& info) {
  const bool remap = true;
  const std::string image_topic = handle.resolveName(images);
  const std::string topic = handle.resolveName(info);
  if (topic != handle.resolveName(info, !remap) || image_topic == handle.resolveName(images, !remap))
    return topic;
  return image_topic.substr(0, image_topic.rfind('/') + 1) + "camera_info";
}

}  // namespace

CalibratedImages::CalibratedImages(const ros::NodeHandle& handle, const ParameterMap& parameters,
                                   CameraHandler on_camera, ImageSubscriber::Handler on_image)
    : handle_(handle),
      configured_(readParams<CameraParams>(parameters).model()),
      on_camera_(std::move(on_camera)),
      images_(handle, readParams<NodeParams>(parameters), readParams<ImageStageParams>(parameters),
              topicName(readParams<NodeParams>(parameters).topic_root, "camera/image"), std::move(on_image)),
      camera_info_watch_(
          cameraInfoTopic(handle, topicName(readParams<NodeParams>(parameters).topic_root, "camera/image"),
                          topicName(readParams<NodeParams>(parameters).topic_root, "camera/camera_info")),
          "sensor_msgs/CameraInfo") {}

void CalibratedImages::start() {
  if (on_camera_ && configured_) on_camera_(*configured_);
  ready_ = !on_camera_ || configured_;
  if (!ready_) {
    images_.hold();
    camera_info_watch_.start();
    camera_info_subscriber_ = handle_.subscribe<sensor_msgs::CameraInfo>(
        camera_info_watch_.topic(), 10, [this](const sensor_msgs::CameraInfoConstPtr& message) {
          camera_info_watch_.messageArrived();
          if (!ready_) onCameraInfo(*message);
        });
  }
  images_.start();
}

void CalibratedImages::onCameraInfo(const sensor_msgs::CameraInfo& message) {
  try {
    const CameraModel camera = cameraFromMessage(message, isRectifiedTopic(topic()));
    const auto doubt = camera.doubt();
    if (doubt) ROS_WARN("%s: %s", camera_info_watch_.topic().c_str(), doubt->c_str());
    on_camera_(camera);
  } catch (const std::invalid_argument& e) {
    no_calibration_.report(camera_info_watch_.topic() + " holds no usable calibration: " + e.what() +
                           kHowToCalibrate);
    return;
  }
  ready_ = true;
  images_.release();
}

void CalibratedImages::warnIfSomethingNeverCame() {
  images_.watch().warnIfItNeverCame();
  if (ready_ || !images_.somethingWaits()) return;
  camera_info_watch_.warnIfItNeverCame();
  if (!camera_info_watch_.came()) {
    no_calibration_.report("images wait for " + camera_info_watch_.topic() + kHowToCalibrate);
  }
}

}  // namespace ratslam
