/// Motion between two views and their common points, from matches alone. A map starts with it.
///
/// 1. Fit two models with RANSAC: a homography (for a flat scene) and an essential matrix (for any other).
/// 2. Score each by its truncated transfer errors, and decompose the better one (Faugeras and Lustman 1988; Hartley
///    and Zisserman, ch. 9).
/// 3. Accept the solution that puts clearly more points in front of both cameras than any other, with enough
///    parallax. With a very short baseline the direction of motion would be random.
#pragma once

#include <optional>
#include <vector>

#include "ratslam/camera/camera_model.h"
#include "ratslam/vision/rigid_transform.h"

namespace ratslam {

struct TwoViewParams {
  int min_points = 80;            ///< points triangulated with small error
  double min_parallax_deg = 1.0;  ///< median over the triangulated points
  double max_error = 1.0;         ///< distance of an inlier from its model [px]
};

struct TwoViewMotion {
  RigidTransform T_second_first;                       ///< |translation| = 1
  std::vector<std::optional<Eigen::Vector3d>> points;  ///< one per match, in the first camera's frame
  int triangulated = 0;
  double parallax_deg = 0.0;  ///< median
};

/// @param first, second matched undistorted pixels, one to one.
/// @return none if the motion is not certain.
std::optional<TwoViewMotion> estimateTwoViewMotion(const CameraModel& camera,
                                                   const std::vector<Eigen::Vector2d>& first,
                                                   const std::vector<Eigen::Vector2d>& second,
                                                   const TwoViewParams& params);

}  // namespace ratslam
