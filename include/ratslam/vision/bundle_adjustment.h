/// Windowed bundle adjustment: Levenberg-Marquardt on poses and points. The points are eliminated first (Schur
/// complement). Source: Triggs et al., Bundle Adjustment - A Modern Synthesis (2000).
///
///   minimise   sum rho( |project(T_pose point) - pixel|^2 / sigma^2 )      rho: Huber's loss
///
/// over the free poses and all points. The fixed poses determine position, direction and scale.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "ratslam/camera/camera_model.h"
#include "ratslam/vision/rigid_transform.h"

namespace ratslam {

struct BundleObservation {
  int pose = 0;                                     ///< index into poses
  int point = 0;                                    ///< index into points
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted
  double sigma = 1.0;                               ///< [px]
};

struct BundleProblem {
  std::vector<RigidTransform> poses;  ///< camera from world; the first `free_poses` are estimated
  int free_poses = 0;
  std::vector<Eigen::Vector3d> points;          ///< world
  std::vector<BundleObservation> observations;  ///< grouped by point, points in ascending order
};

struct BundleOptions {
  int max_iterations = 5;
  double huber = 2.0;               ///< [sigma]
  double relative_decrease = 1e-4;  ///< a smaller relative decrease of the cost ends the search
};

struct BundleSummary {
  double initial_cost = 0.0;  ///< half the sum of rho
  double final_cost = 0.0;
  int iterations = 0;
};

/// Improves poses and points in place. The cost never rises.
/// @throws std::invalid_argument if an index is out of range or the observations are not grouped by point.
BundleSummary adjustBundle(const CameraModel& camera, BundleProblem& problem, const BundleOptions& options);

}  // namespace ratslam
