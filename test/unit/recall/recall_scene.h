/// A street of textured planes seen by a pinhole camera: images whose geometry is known exactly.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "ratslam/vision/recall_features.h"

namespace ratslam {

/// Patches of random grey and size, in levels of half the size each: a texture that can be seen from far
/// away.
inline std::vector<cv::Mat> makeTexture(unsigned seed) {
  constexpr int kSide = 1024;
  std::mt19937 generator(seed);
  const auto draw = [&generator](int below) {
    return static_cast<int>(generator() % static_cast<unsigned>(below));
  };
  cv::Mat texture(kSide, kSide, CV_8U, cv::Scalar(128));
  for (int i = 0; i < 6000; ++i) {
    const int size = 6 + draw(40);
    cv::rectangle(texture, cv::Rect(draw(kSide), draw(kSide), size, 6 + draw(40)), cv::Scalar(20 + draw(215)),
                  -1);
  }
  cv::GaussianBlur(texture, texture, {5, 5}, 1.0);
  std::vector<cv::Mat> levels{texture};
  while (levels.back().cols > 64) {
    cv::Mat half;
    cv::resize(levels.back(), half, {}, 0.5, 0.5, cv::INTER_AREA);
    levels.push_back(half);
  }
  return levels;
}

class RecallScene {
 public:
  /// @param flat a single wall 10 m ahead instead of a street
  explicit RecallScene(unsigned seed, bool flat = false) {
    if (flat) {
      planes_ = {{Eigen::Vector3d::UnitZ(), 10.0, makeTexture(seed)}};
      return;
    }
    planes_ = {{-Eigen::Vector3d::UnitX(), 5.0, makeTexture(seed)},       // left wall
               {Eigen::Vector3d::UnitX(), 6.0, makeTexture(seed + 1)},    // right wall
               {Eigen::Vector3d::UnitY(), 1.6, makeTexture(seed + 2)},    // ground
               {Eigen::Vector3d::UnitZ(), 30.0, makeTexture(seed + 3)}};  // end of the street
  }

  static CameraModel camera() { return {640, 240, 360.0, 360.0, 319.5, 119.5, LensModel::kNone, {}}; }

  /// What a camera `forward` and `left` [m] of the origin sees, turned left by `heading` [rad].
  cv::Mat view(double forward, double left, double heading) const {
    const CameraModel camera = RecallScene::camera();
    const Eigen::Vector3d centre(-left, 0.0, forward);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(-heading, Eigen::Vector3d::UnitY()).toRotationMatrix();
    cv::Mat image(240, 640, CV_8U, cv::Scalar(200));
    for (int v = 0; v < image.rows; ++v) {
      for (int u = 0; u < image.cols; ++u) {
        const Eigen::Vector3d ray =
            turn * Eigen::Vector3d((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
        double nearest = 1e9;
        for (const Plane& plane : planes_) {
          const double towards = plane.normal.dot(ray);
          if (towards < 1e-6) continue;
          const double range = (plane.distance - plane.normal.dot(centre)) / towards;
          if (range <= 0.0 || range >= nearest) continue;
          nearest = range;
          image.at<std::uint8_t>(v, u) = colour(plane, centre + range * ray, range / camera.fx);
        }
      }
    }
    return image;
  }

 private:
  struct Plane {
    Eigen::Vector3d normal;
    double distance;
    std::vector<cv::Mat> texture;
  };

  /// @param footprint of a pixel on a plane that faces it [m]
  static std::uint8_t colour(const Plane& plane, const Eigen::Vector3d& at, double footprint) {
    constexpr double kTexelsPerMetre = 40.0;
    const int level =
        std::clamp(static_cast<int>(std::log2(std::max(1.0, footprint * kTexelsPerMetre)) + 0.5), 0,
                   static_cast<int>(plane.texture.size()) - 1);
    const cv::Mat& texture = plane.texture[static_cast<std::size_t>(level)];
    const double scale = kTexelsPerMetre / std::exp2(level);
    // The two coordinates along the plane.
    const bool sideways = std::abs(plane.normal.x()) > 0.5;
    const bool ground = std::abs(plane.normal.y()) > 0.5;
    const double a = scale * (sideways ? at.z() : at.x());
    const double b = scale * (ground ? at.z() : at.y());
    const double a0 = std::floor(a);
    const double b0 = std::floor(b);
    const auto texel = [&texture](double x, double y) {
      const int side = texture.cols;
      const auto wrap = [side](double value) { return ((static_cast<int>(value) % side) + side) % side; };
      return static_cast<double>(texture.at<std::uint8_t>(wrap(y), wrap(x)));
    };
    const double top = texel(a0, b0) + (a - a0) * (texel(a0 + 1.0, b0) - texel(a0, b0));
    const double bottom = texel(a0, b0 + 1.0) + (a - a0) * (texel(a0 + 1.0, b0 + 1.0) - texel(a0, b0 + 1.0));
    return cv::saturate_cast<std::uint8_t>(top + (b - b0) * (bottom - top));
  }

  std::vector<Plane> planes_;
};

}  // namespace ratslam
