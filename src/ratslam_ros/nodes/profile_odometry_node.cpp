#include "ratslam_ros/nodes/profile_odometry_node.h"

#include <algorithm>

#include "ratslam/common/angles.h"
#include "ratslam_ros/support/conversions.h"

namespace ratslam {
namespace {

/// The profile difference measures speed only as well as vtrans_scaling suits the scene: about a quarter of
/// it.
constexpr double kSpeedError = 0.25;
constexpr double kSmallestSpeedError = 0.1;  // [m/s]
/// Axes that a planar odometry holds at zero by assumption.
constexpr double kAssumedVariance = 1e-6;

}  // namespace

ProfileOdometryNode::ProfileOdometryNode(ros::NodeHandle handle, const ParameterMap& parameters)
    : params_(readParams<NodeParams>(parameters)),
      odometry_params_(readParams<ProfileOdometryParams>(parameters)),
      source_(odometry_params_),
      publisher_(handle, params_),
      images_(handle, params_, readParams<ImageStageParams>(parameters),
              topicName(params_.topic_root, "camera/image"),
              [this](const std_msgs::Header& header, const ImageFrame& frame) { onImage(header, frame); }) {
  gate_.emplace(handle, std::vector<ros::Publisher>{publisher_.publisher()}, params_.wait_for_subscribers,
                [this] { images_.start(); });
  watch_timer_ = handle.createWallTimer(
      ros::WallDuration(1.0), [this](const ros::WallTimerEvent&) { images_.watch().warnIfItNeverCame(); });
}

void ProfileOdometryNode::onImage(const std_msgs::Header&, const ImageFrame& frame) {
  if (frame.begins_anew) last_stamp_.reset();
  const double dt = last_stamp_ ? secondsBetween(*last_stamp_, frame.stamp) : 0.0;
  const OdometrySample sample = source_.track(frame);
  last_stamp_ = frame.stamp;
  publisher_.publish(sample, Twist::Zero(), covariance(sample, frame.image.cols, dt));
}

TwistCovariance ProfileOdometryNode::covariance(const OdometrySample& sample, int image_columns,
                                                double dt) const {
  const double speed_error = std::max(kSmallestSpeedError, kSpeedError * sample.speed);
  const double turn_error = degreesToRadians(odometry_params_.fov_deg) / image_columns;  // one pixel
  const double yaw_rate_error = turn_error / (dt > 0.0 ? dt : 1.0 / odometry_params_.camera_hz);
  TwistCovariance covariance = TwistCovariance::Identity() * kAssumedVariance;
  covariance(0, 0) = speed_error * speed_error;
  covariance(5, 5) = yaw_rate_error * yaw_rate_error;
  return covariance;
}

}  // namespace ratslam
