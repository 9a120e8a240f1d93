/// Camera pose from landmarks of known position: robust reprojection error, Gauss-Newton on SE(3).
///
///   minimise over T   sum_i rho( |pixel_i - project(T point_i)|^2 / (sigma_i s)^2 )
///
/// rho is Huber's loss. The scale s of the errors is estimated from their median absolute deviation before each
/// round (Hartley and Zisserman, Multiple View Geometry, A6.8), because a fixed gate at an assumed noise biases the
/// scale of a monocular path. Observations beyond the gate are left out of a round, but may return in the next.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ratslam/camera/camera_model.h"
#include "ratslam/vision/rigid_transform.h"

namespace ratslam {

struct PoseObservation {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< world
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted
  double sigma = 1.0;                               ///< relative
};

struct RobustLoss {
  double huber = 2.0;      ///< error at which the loss turns from quadratic to linear [sigma]
  double gate = 12.0;      ///< squared error beyond which an observation is an outlier [sigma^2]
  double min_sigma = 0.2;  ///< least scale of the errors [px]
};

struct PoseEstimate {
  RigidTransform T_camera_world;
  Matrix6 covariance = Matrix6::Zero();  ///< of the left increment (translation, rotation)
  double sigma = 1.0;                    ///< scale of the reprojection errors [px]
  std::vector<bool> inlier;              ///< one per observation
  int inliers = 0;
};

/// Reprojection error [px] and its derivative by the left increment of the pose (translation, rotation).
struct Reprojection {
  Eigen::Vector2d error = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> by_point_in_camera = Eigen::Matrix<double, 2, 3>::Zero();
  double depth = 0.0;  ///< the other members are valid only if it is positive

  /// by_point_in_camera * (I, -skew(point_in_camera)), without the products with its zeros.
  Eigen::Matrix<double, 2, 6> byPose(const Eigen::Vector3d& point_in_camera) const {
    const Eigen::Vector3d& p = point_in_camera;
    const double a = by_point_in_camera(0, 0);
    const double b = by_point_in_camera(0, 2);
    const double c = by_point_in_camera(1, 1);
    const double d = by_point_in_camera(1, 2);
    Eigen::Matrix<double, 2, 6> jacobian;
    jacobian << a, 0.0, b, b * p.y(), a * p.z() - b * p.x(), -a * p.y(),  //
        0.0, c, d, d * p.y() - c * p.z(), -d * p.x(), c * p.x();
    return jacobian;
  }
  /// Derivative by the point in the world. @param rotation camera from world. Also without the zeros.
  Eigen::Matrix<double, 2, 3> byPoint(const Eigen::Matrix3d& rotation) const {
    Eigen::Matrix<double, 2, 3> jacobian;
    jacobian.row(0) = by_point_in_camera(0, 0) * rotation.row(0) + by_point_in_camera(0, 2) * rotation.row(2);
    jacobian.row(1) = by_point_in_camera(1, 1) * rotation.row(1) + by_point_in_camera(1, 2) * rotation.row(2);
    return jacobian;
  }
};
constexpr double kMinDepth = 1e-6;  ///< points with less depth are not projected

/// project(point) - pixel, for a point in the camera frame.
inline Reprojection reproject(const CameraModel& camera, const Eigen::Vector3d& point_in_camera,
                              const Eigen::Vector2d& pixel) {
  Reprojection result;
  result.depth = point_in_camera.z();
  if (result.depth <= kMinDepth) return result;
  const double inverse = 1.0 / result.depth;
  const double x = point_in_camera.x() * inverse;
  const double y = point_in_camera.y() * inverse;
  result.error = Eigen::Vector2d(camera.fx * x + camera.cx, camera.fy * y + camera.cy) - pixel;
  result.by_point_in_camera << camera.fx * inverse, 0.0, -camera.fx * x * inverse,  //
      0.0, camera.fy * inverse, -camera.fy * y * inverse;
  return result;
}

/// Standard deviation of one coordinate of two-dimensional Gaussian errors, from the median of their lengths.
double robustSigma(std::vector<double> error_lengths);

/// @return with fewer than 6 observations the initial pose with inliers = 0.
PoseEstimate refinePose(const CameraModel& camera, const RigidTransform& initial,
                        const std::vector<PoseObservation>& observations, const RobustLoss& loss);

}  // namespace ratslam
