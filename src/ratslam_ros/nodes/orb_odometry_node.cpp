#include "ratslam_ros/nodes/orb_odometry_node.h"

#include "ratslam_ros/support/conversions.h"

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
    : params_(readParams<NodeParams>(parameters)),
      odometry_params_(readParams<OrbOdometryParams>(parameters)),
      publisher_(handle, params_),
      display_(handle, params_),
      images_(
          handle, params_, readParams<CameraParams>(parameters),
          [this](const CameraModel& camera) { useCamera(camera); },
          [this](const std_msgs::Header& header, const cv::Mat& image) { onImage(header, image); }) {
  gate_.emplace(handle, std::vector<ros::Publisher>{publisher_.publisher()}, params_.wait_for_subscribers,
                [this] { images_.start(); });
  watch_timer_ = handle.createWallTimer(ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) {
    images_.warnIfSomethingNeverCame();
    display_.publishStatus(odometry_ ? &*odometry_ : nullptr);
  });
}

void OrbOdometryNode::useCamera(const CameraModel& camera) {
  camera_ = camera;
  odometry_.emplace(camera, odometry_params_);
}

void OrbOdometryNode::onImage(const std_msgs::Header& header, const cv::Mat& image) {
  const Stamp stamp = stampFromRos(header.stamp);
  if (last_stamp_ && stamp < *last_stamp_) {
    time_went_back_.report("time went back on " + images_.topic() + ": the odometry starts anew");
    useCamera(*camera_);
  }
  last_stamp_ = stamp;
  const ros::WallTime begin = ros::WallTime::now();
  const OrbResult result = odometry_->track(stamp, eightBits(image));
  if (result.ignored) {
    repeated_.report(images_.topic() + ": image ignored, it repeats the stamp before it");
    return;
  }
  if (result.restarted) restarted_.report("tracking was lost: a fresh map carries pose and scale on");
  publisher_.publish(result.sample, result.twist, result.covariance);
  display_.show(header, image, *camera_, *odometry_, result, (ros::WallTime::now() - begin).toSec());
}

}  // namespace ratslam
