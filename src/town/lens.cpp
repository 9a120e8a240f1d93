#include "town/lens.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <optional>

#include "ratslam/common/params.h"

namespace ratslam {
namespace {

struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};

Distorted distort(const std::array<double, 5>& d, const Eigen::Vector2d& p) {
  const auto& [k1, k2, p1, p2, k3] = d;
  const double x = p.x();
  const double y = p.y();
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = k1 + r2 * (2.0 * k2 + 3.0 * k3 * r2);  // of radial, by r2
  Distorted result;
  result.point = {x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
                  y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y};
  const double mixed = 2.0 * x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
  result.jacobian << radial + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x, mixed, mixed,
      radial + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
  return result;
}

/// Newton's method from `start`; none if it does not converge or the picture folds over.
std::optional<Eigen::Vector2d> undistort(const std::array<double, 5>& d, const Eigen::Vector2d& target,
                                         Eigen::Vector2d start) {
  for (int i = 0; i < 30; ++i) {
    const Distorted here = distort(d, start);
    if (!(here.jacobian.determinant() > 0.05)) return std::nullopt;
    const Eigen::Vector2d step = here.jacobian.inverse() * (target - here.point);
    start += step;
    if (step.norm() < 1e-10) return start;
  }
  return std::nullopt;
}

}  // namespace

LensMap makeLensMap(const TownCamera& camera) {
  camera.validate();
  LensMap map;
  map.ideal = camera;
  if (!camera.distorted()) return map;
  cv::Mat rays(camera.height, camera.width, CV_64FC2);
  Eigen::Vector2d low(0.0, 0.0);
  Eigen::Vector2d high(0.0, 0.0);
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const Eigen::Vector2d target((column - camera.cx) / camera.fx, (row - camera.cy) / camera.fy);
      const std::optional<Eigen::Vector2d> ray = undistort(camera.distortion, target, target);
      if (!ray)
        throwBadValue("distortion", camera.distortion[0],
                      "the lens (k1 and on) folds the picture over itself");
      low = low.cwiseMin(*ray);
      high = high.cwiseMax(*ray);
      rays.at<cv::Vec2d>(row, column) = {ray->x(), ray->y()};
    }
  }
  constexpr double kBorder = 3.0;  // [px] for the resampling filter
  map.ideal.distortion = {};
  map.ideal.cx = std::ceil(-low.x() * camera.fx + kBorder);
  map.ideal.cy = std::ceil(-low.y() * camera.fy + kBorder);
  const double width = map.ideal.cx + std::ceil(high.x() * camera.fx + kBorder) + 1.0;
  const double height = map.ideal.cy + std::ceil(high.y() * camera.fy + kBorder) + 1.0;
  if (width > 3.0 * camera.width || height > 3.0 * camera.height)
    throwBadValue("distortion", camera.distortion[0],
                  "the lens (k1 and on) spreads the picture beyond three times its size");
  map.ideal.width = static_cast<int>(width);
  map.ideal.height = static_cast<int>(height);
  map.map_x.create(camera.height, camera.width, CV_32F);
  map.map_y.create(camera.height, camera.width, CV_32F);
  for (int row = 0; row < camera.height; ++row)
    for (int column = 0; column < camera.width; ++column) {
      const cv::Vec2d& ray = rays.at<cv::Vec2d>(row, column);
      map.map_x.at<float>(row, column) = static_cast<float>(ray[0] * map.ideal.fx + map.ideal.cx);
      map.map_y.at<float>(row, column) = static_cast<float>(ray[1] * map.ideal.fy + map.ideal.cy);
    }
  return map;
}

}  // namespace ratslam
