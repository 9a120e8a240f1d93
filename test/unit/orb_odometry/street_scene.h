/// A street of textured planes, rendered exactly: a road at y = height and a wall on either side, grey sky
/// above. World axes are the camera's at the start: x right, y down, z forward [m].
#pragma once

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "ratslam/camera/camera_model.h"
#include "ratslam/odometry/orb/orb_params.h"
#include "ratslam/vision/rigid_transform.h"

namespace ratslam::test {

inline constexpr double kStep = 0.4;    ///< of the car [m a frame]
inline constexpr double kPeriod = 0.1;  ///< [s a frame]

inline CameraModel smallCamera() {
  CameraModel camera;
  camera.width = 480;
  camera.height = 160;
  camera.fx = camera.fy = 280.0;
  camera.cx = 239.5;
  camera.cy = 70.0;
  return camera;
}

inline OrbOdometryParams smallParams() {
  OrbOdometryParams params;
  params.features = 1000;
  params.new_landmarks = 150;
  params.init_points = 40;
  return params;
}

class StreetScene {
 public:
  static constexpr double kCameraHeight = 1.65;

  StreetScene() {
    cv::Mat noise(1024, 1024, CV_8UC1);
    cv::RNG generator(7);
    generator.fill(noise, cv::RNG::UNIFORM, 0, 256);
    cv::Mat coarse;
    cv::resize(noise(cv::Rect(0, 0, 128, 128)), coarse, noise.size(), 0, 0, cv::INTER_CUBIC);
    cv::GaussianBlur(noise, noise, {0, 0}, 1.2, 1.2, cv::BORDER_WRAP);
    cv::addWeighted(noise, 1.2, coarse, 0.5, -90.0, noise);
    levels_.push_back(noise);
    while (levels_.back().cols > 8) {
      cv::Mat half;
      cv::resize(levels_.back(), half, {}, 0.5, 0.5, cv::INTER_AREA);
      levels_.push_back(half);
    }
  }

  cv::Mat render(const CameraModel& camera, const RigidTransform& T_world_camera) const {
    cv::Mat image(camera.height, camera.width, CV_8UC1);
    const Eigen::Vector3d& centre = T_world_camera.translation;
    const Eigen::Matrix3d rotation = T_world_camera.rotation.toRotationMatrix();
    for (int v = 0; v < camera.height; ++v) {
      for (int u = 0; u < camera.width; ++u) {
        const Eigen::Vector3d ray = rotation * camera.bearing(camera.undistort(Eigen::Vector2d(u, v)));
        image.at<uchar>(v, u) = shade(camera, centre, ray);
      }
    }
    return image;
  }

 private:
  static constexpr double kHalfWidth = 6.0;  // of the street
  static constexpr double kWallHeight = 9.0;
  static constexpr double kTexelsPerMetre = 28.0;

  uchar shade(const CameraModel& camera, const Eigen::Vector3d& centre, const Eigen::Vector3d& ray) const {
    double nearest = 1e9;
    double s = 0.0;
    double t = 0.0;
    if (ray.y() > 1e-6) {
      nearest = (kCameraHeight - centre.y()) / ray.y();
      s = centre.x() + nearest * ray.x() + 300.0;
      t = centre.z() + nearest * ray.z() + 300.0;
    }
    if (std::abs(ray.x()) > 1e-6) {
      const double side = ray.x() > 0 ? kHalfWidth : -kHalfWidth;
      const double distance = (side - centre.x()) / ray.x();
      const double height = centre.y() + distance * ray.y();
      if (distance < nearest && height > -kWallHeight) {
        nearest = distance;
        s = height + 500.0 + 37.0 * side;
        t = centre.z() + distance * ray.z() + 300.0;
      }
    }
    if (nearest > 150.0) return 128;
    const double footprint = kTexelsPerMetre * nearest / camera.fx;
    const double level = std::max(
        0.0, std::min(std::log2(std::max(1e-3, footprint)) + 0.5, static_cast<double>(levels_.size()) - 2.0));
    const int low = static_cast<int>(level);
    const double share = level - low;
    const double grey = (1.0 - share) * sample(low, s, t) + share * sample(low + 1, s, t);
    return cv::saturate_cast<uchar>(grey);
  }

  double sample(int level, double s, double t) const {
    const cv::Mat& texture = levels_[static_cast<std::size_t>(level)];
    const double shrink = std::pow(0.5, level);
    const double x = s * kTexelsPerMetre * shrink - 0.5 + 4096.0;
    const double y = t * kTexelsPerMetre * shrink - 0.5 + 4096.0;
    const int column = static_cast<int>(std::floor(x));
    const int row = static_cast<int>(std::floor(y));
    const double fx = x - column;
    const double fy = y - row;
    const int mask = texture.cols - 1;
    const auto at = [&](int r, int c) { return static_cast<double>(texture.at<uchar>(r & mask, c & mask)); };
    return (1 - fy) * ((1 - fx) * at(row, column) + fx * at(row, column + 1)) +
           fy * ((1 - fx) * at(row + 1, column) + fx * at(row + 1, column + 1));
  }

  std::vector<cv::Mat> levels_;
};

/// Camera pose on the road: z forward, x right; yaw turns left (counter-clockwise seen from above).
inline RigidTransform cameraAt(double x, double z, double yaw = 0.0) {
  return {expRotation({0.0, -yaw, 0.0}), Eigen::Vector3d(x, 0.0, z)};
}

}  // namespace ratslam::test
