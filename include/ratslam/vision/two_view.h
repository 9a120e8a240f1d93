/// Motion between two views and the points they share, from matches alone: how a map begins.
///
/// Two models are fitted with RANSAC: a homography (a flat scene) and an essential matrix (any other). Each
/// gets a score from its truncated transfer errors, and the better one is decomposed (Faugeras and Lustman
/// 1988; Hartley and Zisserman, ch. 9). The solution must put clearly more points before both cameras than
/// any other, with enough parallax to believe their depths: with a baseline near nothing the direction of
/// motion is random.
#pragma once

#include <optional>
#include <vector>

#include "ratslam/camera/camera_model.h"
#include "ratslam/vision/rigid_transform.h"

namespace ratslam {

struct TwoViewParams {
  int min_points = 80;            ///< triangulated with small error
  double min_parallax_deg = 1.0;  ///< median over the triangulated points
  double max_error = 1.0;         ///< distance of an inlier from its model [px]
};

struct TwoViewMotion {
  RigidTransform T_second_first;                       ///< |translation| = 1
  std::vector<std::optional<Eigen::Vector3d>> points;  ///< one a match, in the first camera's frame
  int triangulated = 0;
  double parallax_deg = 0.0;  ///< median
};

/// @param first, second matched undistorted pixels, one to one.
/// @return nothing where the motion is not certain.
std::optional<TwoViewMotion> estimateTwoViewMotion(const CameraModel& camera,
                                                   const std::vector<Eigen::Vector2d>& first,
                                                   const std::vector<Eigen::Vector2d>& second,
                                                   const TwoViewParams& params);

}  // namespace ratslam
