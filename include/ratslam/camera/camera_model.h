/// Camera geometry: a pinhole behind a lens, with the lens models that sensor_msgs/CameraInfo names.
///
/// Points are undistorted, images are not. Three kinds of coordinates:
///   raw pixel    where a point lies in the image as it came, pixel centres at whole numbers;
///   pixel        where an ideal pinhole of the same fx, fy, cx, cy would have put it ("undistorted");
///   bearing      (X/Z, Y/Z) in the camera frame: x right, y down, z forward.
/// Lens models: plumb_bob (Brown-Conrady k1 k2 p1 p2 k3), rational_polynomial (k1 k2 p1 p2 k3 k4 k5 k6) and
/// equidistant (Kannala-Brandt k1..k4), with OpenCV's order and meaning of coefficients.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace ratslam {

enum class LensModel { kNone, kPlumbBob, kRationalPolynomial, kEquidistant };

/// The model that a name of sensor_msgs/CameraInfo stands for; an empty name is kNone.
/// @throws std::invalid_argument for any other name.
LensModel lensModelFromName(const std::string& name);

/// What is added to the coefficients k1, k2, p1, p2 of a lens.
using LensChange = Eigen::Vector4d;

/// Where the lens puts an undistorted pixel, and the derivative by it.
struct DistortedPixel {
  Eigen::Vector2d raw;
  Eigen::Matrix2d jacobian;
};

struct CameraModel {
  int width = 0;    ///< [px]
  int height = 0;   ///< [px]
  double fx = 0.0;  ///< focal lengths [px]
  double fy = 0.0;
  double cx = 0.0;  ///< principal point [px]
  double cy = 0.0;
  LensModel model = LensModel::kNone;
  std::vector<double> coefficients;  ///< missing ones are zero

  /// @throws std::invalid_argument naming what is wrong.
  void validate() const;

  /// What makes it likely that the calibration belongs to images of another size or cut, or to another camera: a
  /// principal point far from the middle, coefficients that leave nothing of the picture. None where nothing does.
  std::optional<std::string> doubt() const;

  /// Raw pixels to undistorted pixels. Points the lens model cannot have produced come back as near as
  /// Newton's method gets; they are finite always.
  std::vector<Eigen::Vector2d> undistort(const std::vector<Eigen::Vector2d>& raw) const;
  Eigen::Vector2d undistort(const Eigen::Vector2d& raw) const;
  /// The same, sooner where something near the result is known.
  Eigen::Vector2d undistort(const Eigen::Vector2d& raw, const Eigen::Vector2d& guess) const;
  /// The inverse of undistort.
  Eigen::Vector2d distort(const Eigen::Vector2d& pixel) const;
  DistortedPixel distortWithJacobian(const Eigen::Vector2d& pixel) const;
  /// The same camera with something added to k1, k2 and, where the lens model has them, p1, p2; one without a
  /// lens model gets plumb_bob.
  CameraModel withLensChange(const LensChange& change) const;

  /// Pinhole projection of a point in the camera frame (z > 0) to an undistorted pixel.
  Eigen::Vector2d project(const Eigen::Vector3d& point) const {
    return {fx * point.x() / point.z() + cx, fy * point.y() / point.z() + cy};
  }
  /// Ray of an undistorted pixel, with z = 1.
  Eigen::Vector3d bearing(const Eigen::Vector2d& pixel) const {
    return {(pixel.x() - cx) / fx, (pixel.y() - cy) / fy, 1.0};
  }
  Eigen::Matrix3d matrix() const {
    Eigen::Matrix3d k;
    k << fx, 0, cx, 0, fy, cy, 0, 0, 1;
    return k;
  }
};

/// The camera of a calibration file or message, validated. A lens all of whose coefficients are zero is none;
/// zeros behind those that its model has are dropped.
/// @throws std::invalid_argument naming what is wrong
CameraModel makeCamera(CameraModel pinhole, const std::string& lens_name, std::vector<double> coefficients);

}  // namespace ratslam
