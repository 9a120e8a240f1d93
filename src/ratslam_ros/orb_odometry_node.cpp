#include "ratslam_ros/orb_odometry_node.h"

#include "ratslam_ros/camera_info.h"
#include "ratslam_ros/conversions.h"

namespace ratslam {
namespace {

/// The odometry looks at 8 bits; a sensor's upper ones are those that matter.
cv::Mat eightBits(const cv::Mat& image) {
  if (image.depth() != CV_16U) return image;
  cv::Mat converted;
  image.convertTo(converted, CV_8U, 255.0 / 65535.0);
  return converted;
}

}  // namespace

OrbOdometryNode::OrbOdometryNode(ros::NodeHandle handle, const ParameterMap& parameters)
    : handle_(handle),
      params_(readParams<NodeParams>(parameters)),
      odometry_params_(readParams<OrbOdometryParams>(parameters)),
      publisher_(handle_, params_),
      display_(handle_, params_),
      images_(handle_, params_, topicName(params_.topic_root, "camera/image"),
              [this](const std_msgs::Header& header, const cv::Mat& image) { onImage(header, image); }),
      camera_info_watch_(handle_.resolveName(topicName(params_.topic_root, "camera/camera_info")),
                         "sensor_msgs/CameraInfo") {
  if (const auto configured = readParams<CameraParams>(parameters).model()) useCamera(*configured);
  gate_.emplace(handle_, std::vector<ros::Publisher>{publisher_.publisher()}, params_.wait_for_subscribers,
                [this] { start(); });
  watch_timer_ = handle_.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) {
    images_.watch().warnIfItNeverCame();
    if (!odometry_ && !waiting_.empty()) camera_info_watch_.warnIfItNeverCame();
    display_.publishStatus(odometry_ ? &*odometry_ : nullptr);
  });
}

void OrbOdometryNode::start() {
  camera_info_watch_.start();
  camera_info_subscriber_ = handle_.subscribe<sensor_msgs::CameraInfo>(
      camera_info_watch_.topic(), 10, [this](const sensor_msgs::CameraInfoConstPtr& message) {
        camera_info_watch_.messageArrived();
        if (!odometry_) onCameraInfo(*message);
      });
  images_.start();
}

void OrbOdometryNode::useCamera(const CameraModel& camera) {
  camera_ = camera;
  odometry_.emplace(camera, odometry_params_);
}

void OrbOdometryNode::onCameraInfo(const sensor_msgs::CameraInfo& message) {
  try {
    useCamera(cameraFromMessage(message));
  } catch (const std::invalid_argument& e) {
    no_calibration_.report(
        camera_info_watch_.topic() + " holds no usable calibration: " + e.what() +
        "; publish one, or set camera_fx, camera_fy, camera_cx, camera_cy, camera_width_px and "
        "camera_height_px (and camera_distortion) in the configuration");
    return;
  }
  for (; !waiting_.empty(); waiting_.pop_front()) track(waiting_.front().header, waiting_.front().image);
}

void OrbOdometryNode::onImage(const std_msgs::Header& header, const cv::Mat& image) {
  if (odometry_) {
    track(header, image);
    return;
  }
  if (params_.image_queue_size > 0 && waiting_.size() >= static_cast<std::size_t>(params_.image_queue_size)) {
    waiting_.pop_front();
    no_calibration_.report("images are lost, they wait for a calibration: publish " +
                           camera_info_watch_.topic() +
                           ", or set camera_fx, camera_fy, camera_cx, camera_cy, camera_width_px and "
                           "camera_height_px (and camera_distortion) in the configuration");
  }
  waiting_.push_back({header, image.clone()});
}

void OrbOdometryNode::track(const std_msgs::Header& header, const cv::Mat& image) {
  const Stamp stamp = stampFromRos(header.stamp);
  if (last_stamp_ && stamp < *last_stamp_) {
    time_went_back_.report("time went back on " + images_.watch().topic() + ": the odometry starts anew");
    useCamera(*camera_);
  }
  last_stamp_ = stamp;
  const ros::WallTime begin = ros::WallTime::now();
  const OrbResult result = odometry_->track(stamp, eightBits(image));
  if (result.ignored) {
    repeated_.report(images_.watch().topic() + ": image ignored, it repeats the stamp before it");
    return;
  }
  if (result.restarted) restarted_.report("tracking was lost: a fresh map carries pose and scale on");
  publisher_.publish(result.sample, result.twist, result.covariance);
  display_.show(header, image, *camera_, *odometry_, result, (ros::WallTime::now() - begin).toSec());
}

}  // namespace ratslam
