#include "ratslam_ros/support/calibrated_images.h"

#include <algorithm>
#include <tuple>

#include "ratslam_ros/support/camera_info.h"
#include "ratslam_ros/support/checked_subscription.h"
#include "ratslam_ros/support/node_failure.h"
#include "ratslam_ros/support/node_parameters.h"

namespace ratslam {
namespace {

const char kHowToCalibrate[] =
    "; publish a calibration there, or set camera_fx, camera_fy, camera_cx, camera_cy, camera_width_px and "
    "camera_height_px (and camera_distortion) in the configuration";

/// Topic of the calibration. If only the images have been remapped, it is the camera_info beside them, as for
/// image_transport's camera subscribers.
std::string cameraInfoTopic(const ros::NodeHandle& handle, const std::string& images,
                            const std::string& info) {
  const bool remap = true;
  const std::string image_topic = handle.resolveName(images);
  std::string topic = handle.resolveName(info);
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
  if (on_camera_ && configured_) handOn(*configured_);
  if (failed_) return;
  ready_ = !on_camera_ || configured_;
  if (!ready_) {
    images_.hold([this](const RecordedImage& image) { onWaitingImage(image); });
    camera_info_watch_.start();
    camera_info_subscriber_ = subscribeChecked<sensor_msgs::CameraInfo>(
        handle_, camera_info_watch_.topic(), 10,
        [this](const ros::MessageEvent<const sensor_msgs::CameraInfo>& event) {
          camera_info_watch_.messageArrived();
          if (!ready_) onCameraInfo(*event.getConstMessage());
        },
        [this](const std::string& why) { sayUnusable(why); });
  }
  images_.start();
}

void CalibratedImages::handOn(const CameraModel& camera) {
  try {
    on_camera_(camera);
  } catch (const std::invalid_argument& e) {
    if (!configured_) throw;  // another message may hold a calibration that can be used
    failed_ = true;
    failNode(e);
  } catch (const std::exception& e) {
    failed_ = true;
    failNode(e);
  }
}

void CalibratedImages::onCameraInfo(const sensor_msgs::CameraInfo& message) {
  constexpr std::size_t kMostSizes = 16;  // a camera has only a few sizes
  const auto readout = [](const sensor_msgs::CameraInfo& info) {
    return std::make_tuple(info.width, info.height, info.binning_x, info.binning_y, info.roi.x_offset,
                           info.roi.y_offset, info.roi.width, info.roi.height);
  };
  const auto same_readout = [&](const sensor_msgs::CameraInfo& info) {
    return readout(info) == readout(message);
  };
  if (infos_.size() >= kMostSizes || std::any_of(infos_.begin(), infos_.end(), same_readout)) return;
  try {
    const bool sized = message.width > 0 && message.height > 0;
    if (sized) cameraFromMessage(message, isRectifiedTopic(topic()));
    infos_.push_back(message);
  } catch (const std::invalid_argument& e) {
    sayUnusable(e.what());
  }
  chooseCamera();
}

void CalibratedImages::onWaitingImage(const RecordedImage& image) {
  newest_ = image;
  chooseCamera();
}

void CalibratedImages::chooseCamera() {
  if (failed_ || !newest_ || infos_.empty()) return;
  const cv::Size size = decodeNow(*newest_).image.size();
  if (size.empty()) return;  // a corrupt image; wait for the next one
  std::string reason;
  for (const sensor_msgs::CameraInfo& info : infos_) {
    try {
      const CameraModel camera = cameraFromMessage(info, isRectifiedTopic(topic()), size);
      const auto doubt = camera.doubt();
      if (doubt) ROS_WARN("%s: %s", camera_info_watch_.topic().c_str(), doubt->c_str());
      handOn(camera);
      if (failed_) return;
      ready_ = true;
      break;
    } catch (const std::invalid_argument& e) {
      reason = e.what();
    }
  }
  if (!ready_) return sayUnusable(reason);
  infos_.clear();
  newest_.reset();
  images_.release();
}

void CalibratedImages::sayUnusable(const std::string& why) {
  no_calibration_.report(camera_info_watch_.topic() + " holds no usable calibration: " + why +
                         kHowToCalibrate);
}

void CalibratedImages::warnIfSomethingNeverCame() {
  images_.watchStream();
  if (failed_ || ready_ || !images_.somethingWaits()) return;
  camera_info_watch_.warnIfItNeverCame();
  if (!camera_info_watch_.came()) {
    no_calibration_.report("images wait for " + camera_info_watch_.topic() + kHowToCalibrate);
  }
}

}  // namespace ratslam
