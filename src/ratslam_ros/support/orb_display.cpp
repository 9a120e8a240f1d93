#include "ratslam_ros/support/orb_display.h"

#include <cv_bridge/cv_bridge.h>
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

}  // namespace

OrbDisplay::OrbDisplay(const NodeParams& params, ros::NodeHandle own) : odom_frame_(params.odomFrame()) {
  debug_image_ = own.advertise<sensor_msgs::Image>("debug_image", 1);
  landmarks_ = own.advertise<sensor_msgs::PointCloud2>("landmarks", 1);
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

void OrbDisplay::describe(DiagnosticStatus& status, const OrbOdometry* odometry) {
  if (odometry == nullptr) {
    status.summary(DiagnosticStatus::ERROR, "no calibration");
  } else if (!last_) {
    status.summary(DiagnosticStatus::STALE, "no images");
  } else {
    const bool works = last_->state == OrbState::kTracking || last_->state == OrbState::kInitialising;
    status.summary(works ? DiagnosticStatus::OK : DiagnosticStatus::WARN, nameOf(last_->state));
    status.add("tracked points", last_->tracked_points);
    status.add("keyframes", last_->keyframes);
    status.add("landmarks", last_->landmarks);
    status.add("restarts", odometry->restarts());
    status.add("images", images_);
    status.add("mean ms per image", images_ > 0 ? 1e3 * summed_s_ / images_ : 0.0);
    status.add("slowest image [ms]", 1e3 * slowest_s_);
  }
  slowest_s_ = summed_s_ = 0.0;
  images_ = 0;
}

}  // namespace ratslam
