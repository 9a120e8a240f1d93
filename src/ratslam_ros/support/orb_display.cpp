#include "ratslam_ros/support/orb_display.h"

#include <cv_bridge/cv_bridge.h>
#include <diagnostic_msgs/DiagnosticArray.h>
#include <ros/this_node.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/PointCloud2.h>
#include <sensor_msgs/point_cloud2_iterator.h>

#include <algorithm>

#include "ratslam/view/draw_features.h"

namespace ratslam {
namespace {

const char* nameOf(OrbState state) {
  switch (state) {
    case OrbState::kInitialising:
      return "initialising";
    case OrbState::kTracking:
      return "tracking";
    case OrbState::kLost:
      return "lost";
    case OrbState::kRelocalising:
      return "relocalising";
  }
  return "";
}

template <class Value>
diagnostic_msgs::KeyValue keyValue(const char* key, const Value& value) {
  diagnostic_msgs::KeyValue message;
  message.key = key;
  message.value = std::to_string(value);
  return message;
}

}  // namespace

OrbDisplay::OrbDisplay(ros::NodeHandle& handle, const NodeParams& params) : odom_frame_(params.odom_frame) {
  ros::NodeHandle private_handle("~");
  debug_image_ = private_handle.advertise<sensor_msgs::Image>("debug_image", 1);
  landmarks_ = private_handle.advertise<sensor_msgs::PointCloud2>("landmarks", 1);
  diagnostics_ = handle.advertise<diagnostic_msgs::DiagnosticArray>("diagnostics", 10);
}

void OrbDisplay::show(const std_msgs::Header& header, const cv::Mat& image, const CameraModel& camera,
                      const OrbOdometry& odometry, const OrbResult& result, double seconds) {
  last_ = result;
  slowest_s_ = std::max(slowest_s_, seconds);
  summed_s_ += seconds;
  ++images_;
  if (debug_image_.getNumSubscribers() > 0 && odometry.frame() != nullptr) {
    debug_image_.publish(
        cv_bridge::CvImage(header, "bgr8", drawFeatures(image, *odometry.frame(), camera)).toImageMsg());
  }
  if (landmarks_.getNumSubscribers() > 0) publishLandmarks(header, odometry);
}

void OrbDisplay::publishLandmarks(const std_msgs::Header& header, const OrbOdometry& odometry) {
  const std::vector<Eigen::Vector3d> positions = odometry.landmarkPositions();
  sensor_msgs::PointCloud2 cloud;
  cloud.header.stamp = header.stamp;
  cloud.header.frame_id = odom_frame_;
  sensor_msgs::PointCloud2Modifier modifier(cloud);
  modifier.setPointCloud2FieldsByString(1, "xyz");
  modifier.resize(positions.size());
  sensor_msgs::PointCloud2Iterator<float> x(cloud, "x");
  sensor_msgs::PointCloud2Iterator<float> y(cloud, "y");
  sensor_msgs::PointCloud2Iterator<float> z(cloud, "z");
  for (const Eigen::Vector3d& position : positions) {
    *x = static_cast<float>(position.x());
    *y = static_cast<float>(position.y());
    *z = static_cast<float>(position.z());
    ++x;
    ++y;
    ++z;
  }
  landmarks_.publish(cloud);
}

void OrbDisplay::publishStatus(const OrbOdometry* odometry) {
  diagnostic_msgs::DiagnosticStatus status;
  status.name = ros::this_node::getName() + ": visual odometry";
  if (odometry == nullptr) {
    status.level = diagnostic_msgs::DiagnosticStatus::ERROR;
    status.message = "no calibration";
  } else if (!last_) {
    status.level = diagnostic_msgs::DiagnosticStatus::STALE;
    status.message = "no images";
  } else {
    const bool works = last_->state == OrbState::kTracking || last_->state == OrbState::kInitialising;
    status.level = works ? diagnostic_msgs::DiagnosticStatus::OK : diagnostic_msgs::DiagnosticStatus::WARN;
    status.message = nameOf(last_->state);
    status.values = {keyValue("tracked points", last_->tracked_points),
                     keyValue("keyframes", last_->keyframes),
                     keyValue("landmarks", last_->landmarks),
                     keyValue("restarts", odometry->restarts()),
                     keyValue("images", images_),
                     keyValue("mean ms per image", images_ > 0 ? 1e3 * summed_s_ / images_ : 0.0),
                     keyValue("slowest image [ms]", 1e3 * slowest_s_)};
  }
  slowest_s_ = summed_s_ = 0.0;
  images_ = 0;
  diagnostic_msgs::DiagnosticArray message;
  message.header.stamp = ros::Time::now();
  message.status.push_back(status);
  diagnostics_.publish(message);
}

}  // namespace ratslam
