/// Camera geometry: a pinhole behind a lens, with the lens models that sensor_msgs/CameraInfo names.
///
/// Points are undistorted, images are not. Three kinds of coordinates:
///   raw pixel    position in the original image, with pixel centres at whole numbers;
///   pixel        position in the image of an ideal pinhole with the same fx, fy, cx, cy ("undistorted");
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

/// The lens model of a name in sensor_msgs/CameraInfo; an empty name is kNone.
/// @throws std::invalid_argument for any other name.
LensModel lensModelFromName(const std::string& name);

/// Change of the coefficients k1, k2, p1, p2 of a lens.
using LensChange = Eigen::Vector4d;

/// The raw pixel of an undistorted pixel, and its derivative by the undistorted pixel.
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

  /// A reason to doubt that the calibration belongs to these images: a principal point far from the middle, or
  /// coefficients that bend the image too much. None if there is no reason.
  std::optional<std::string> doubt() const;

  /// Converts raw pixels to undistorted pixels. For points that the lens model cannot produce the result is the last
  /// step of Newton's method. It is always finite.
  std::vector<Eigen::Vector2d> undistort(const std::vector<Eigen::Vector2d>& raw) const;
  Eigen::Vector2d undistort(const Eigen::Vector2d& raw) const;
  /// The same, but faster, because it starts from a guess. @param guess  a pixel near the result
  Eigen::Vector2d undistort(const Eigen::Vector2d& raw, const Eigen::Vector2d& guess) const;
  /// The inverse of undistort.
  Eigen::Vector2d distort(const Eigen::Vector2d& pixel) const;
  DistortedPixel distortWithJacobian(const Eigen::Vector2d& pixel) const;
  /// The same camera with a change of k1, k2 and, if the lens model has them, p1, p2. A camera without a lens model
  /// gets plumb_bob.
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

/// Makes and validates the camera of a calibration file or message. A lens with only zero coefficients becomes kNone.
/// Zeros beyond the coefficients of the lens model are dropped.
/// @throws std::invalid_argument naming what is wrong
CameraModel makeCamera(CameraModel pinhole, const std::string& lens_name, std::vector<double> coefficients);

/// Refuses the skew of a camera matrix (row 1, column 2) if to leave it out would move a pixel visibly, because the
/// camera model has none.
/// @throws std::invalid_argument with the name and the value
void requireNoSkew(const std::string& name, double skew, const CameraModel& camera);

}  // namespace ratslam
