#include "town/ros/bag_town_sink.h"

#include <cv_bridge/cv_bridge.h>
#include <nav_msgs/Odometry.h>
#include <ros/names.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/NavSatFix.h>
#include <tf2_msgs/TFMessage.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "ratslam/common/atomic_file.h"
#include "ratslam/common/params.h"
#include "ratslam_ros/support/conversions.h"

namespace ratslam {
namespace {

/// Camera axes (x right, y down, z forward) in those of base_link.
Eigen::Matrix3d cameraInBase() {
  Eigen::Matrix3d rotation;
  rotation << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return rotation;
}

std_msgs::Header headerOf(Stamp stamp, const std::string& frame) {
  std_msgs::Header header;
  header.stamp = stampToRos(stamp);
  header.frame_id = frame;
  return header;
}

geometry_msgs::Vector3 vectorToMessage(const Eigen::Vector3d& vector) {
  geometry_msgs::Vector3 message;
  message.x = vector.x();
  message.y = vector.y();
  message.z = vector.z();
  return message;
}

sensor_msgs::CameraInfo cameraInfo(const TownCamera& camera, const std_msgs::Header& header) {
  sensor_msgs::CameraInfo message;
  message.header = header;
  message.width = static_cast<std::uint32_t>(camera.width);
  message.height = static_cast<std::uint32_t>(camera.height);
  message.distortion_model = "plumb_bob";
  message.D.assign(camera.distortion.begin(), camera.distortion.end());
  message.K = {camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0};
  message.R = {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0};
  message.P = {camera.fx, 0.0, camera.cx, 0.0, 0.0, camera.fy, camera.cy, 0.0, 0.0, 0.0, 1.0, 0.0};
  return message;
}

}  // namespace

BagTownSink::BagTownSink(const TownOptions& options, const std::string& root)
    : options_(options),
      camera_(options.camera()),
      root_("/" + root + "/"),
      start_(stampFromSeconds(options.start)),
      part_(options.out + ".part") {
  options.validate();
  options.expectEffects();
  std::string reason;
  if (!ros::names::validate(ros::names::clean(root_), reason))
    throwBadValue("root", root, "it must be a name of ROS, such as town or robot/one");
  expectAbsent(options.out);
  requireWritable(options.out);
}

BagTownSink::~BagTownSink() {
  if (!bag_) return;
  closed();
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
}

void BagTownSink::begin() {
  bag_ = std::make_unique<rosbag::Bag>();
  try {
    bag_->open(part_, rosbag::bagmode::Write);
  } catch (const rosbag::BagException& e) {
    throw std::runtime_error(options_.out + ": cannot write this bag: " + e.what());
  }
  geometry_msgs::TransformStamped camera_in_base;
  camera_in_base.header = headerOf(start_, "base_link");
  camera_in_base.child_frame_id = "camera";
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = cameraInBase();
  camera_in_base.transform = transformToMessage(transform);
  tf2_msgs::TFMessage tree;
  tree.transforms.push_back(camera_in_base);
  write("/tf_static", start_, tree);
}

template <class Message>
void BagTownSink::write(const std::string& topic, Stamp stamp, const Message& message) {
  try {
    bag_->write(ros::names::clean(topic.front() == '/' ? topic : root_ + topic), stampToRos(stamp), message);
  } catch (const rosbag::BagException& e) {
    throw std::runtime_error(options_.out + ": cannot write this bag: " + e.what());
  }
}

void BagTownSink::add(const TownFrame& frame) {
  if (!bag_) begin();
  const Stamp stamp = start_ + frame.stamp;
  writeSensors(frame, stamp);
  writeTruth(frame, stamp);
  writeCamera(frame, stamp);
}

void BagTownSink::writeCamera(const TownFrame& frame, Stamp stamp) {
  const std_msgs::Header header = headerOf(stamp, "camera");
  write("camera/camera_info", stamp, cameraInfo(camera_, header));
  if (options_.jpeg_quality == 0) {
    write("camera/image", stamp, *cv_bridge::CvImage(header, "mono8", frame.image).toImageMsg());
    return;
  }
  sensor_msgs::CompressedImage message;
  message.header = header;
  message.format = "mono8; jpeg compressed";
  cv::imencode(".jpg", frame.image, message.data, {cv::IMWRITE_JPEG_QUALITY, options_.jpeg_quality});
  write("camera/image/compressed", stamp, message);
}

void BagTownSink::writeTruth(const TownFrame& frame, Stamp stamp) {
  if (!first_camera_pose_) first_camera_pose_ = frame.T_world_camera;
  const Eigen::Isometry3d moved = first_camera_pose_->inverse() * frame.T_world_camera;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = cameraInBase() * moved.linear() * cameraInBase().transpose();
  pose.translation() = cameraInBase() * moved.translation();
  nav_msgs::Odometry message;
  message.header = headerOf(stamp, "world");
  message.child_frame_id = "base_link";
  message.pose.pose = poseToMessage(pose);
  if (last_truth_) {
    const double dt = secondsBetween(last_truth_->stamp, stamp);
    const Eigen::Isometry3d step = last_truth_->pose.inverse() * pose;
    const Eigen::AngleAxisd turn(step.linear());
    message.twist.twist.linear = vectorToMessage(step.translation() / dt);
    message.twist.twist.angular = vectorToMessage(turn.angle() * turn.axis() / dt);
  }
  write("ground_truth", stamp, message);
  last_truth_ = Truth{stamp, pose};
}

void BagTownSink::writeSensors(const TownFrame& frame, Stamp stamp) {
  for (const ImuSample& sample : frame.imu) {
    sensor_msgs::Imu message;
    message.header = headerOf(start_ + sample.stamp, "camera");
    message.orientation_covariance[0] = -1.0;  // by convention: no orientation
    message.linear_acceleration = vectorToMessage(sample.acceleration);
    message.angular_velocity = vectorToMessage(sample.angular_rate);
    write("imu", start_ + sample.stamp, message);
  }
  if (frame.gps) {
    sensor_msgs::NavSatFix message;
    message.header = headerOf(stamp, "gps");
    message.latitude = frame.gps->latitude;
    message.longitude = frame.gps->longitude;
    message.altitude = frame.gps->altitude;
    const double variance = frame.gps->accuracy * frame.gps->accuracy;
    message.position_covariance = {variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance};
    message.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_APPROXIMATED;
    write("gps", stamp, message);
  }
  if (frame.wheel) {
    nav_msgs::Odometry message;
    message.header = headerOf(stamp, "odom");
    message.child_frame_id = "base_link";
    message.twist.twist.linear.x = frame.wheel->speed;
    message.twist.twist.angular.z = frame.wheel->yaw_rate;
    if (frame.wheel->covariance) {
      const TwistCovariance& covariance = *frame.wheel->covariance;
      std::copy(covariance.data(), covariance.data() + covariance.size(), message.twist.covariance.begin());
    }
    write("odom", stamp, message);
  }
}

bool BagTownSink::closed() {
  try {
    bag_->close();
    return true;
  } catch (const rosbag::BagException&) {
    // A bag closes itself again when it is destroyed, and what it throws there ends the program. So it is never destroyed.
    static auto* const unclosed = new std::vector<rosbag::Bag*>;
    unclosed->push_back(bag_.release());
    return false;
  }
}

void BagTownSink::finish() {
  if (!bag_) return;
  std::error_code error;
  const bool whole = closed();
  bag_.reset();
  if (whole) std::filesystem::rename(part_, options_.out, error);
  if (whole && !error) return;
  std::filesystem::remove(part_, error);
  throw std::runtime_error(options_.out + ": cannot write this bag to its end");
}

}  // namespace ratslam
