/// New landmarks for a keyframe, from what it and its neighbours see in common.
///
/// Steps for each feature that no landmark explains: search its epipolar line in a neighbour by descriptor;
/// triangulate; sharpen the match by aligning the feature's patch, warped by the depth just found; look for
/// the same patch in the other neighbours, where the point now projects; triangulate from all views; accept
/// if the rays meet at a large enough angle and every reprojection error is small. Hartley and Zisserman,
/// Multiple View Geometry, ch. 12.
#pragma once

#include <optional>
#include <vector>

#include "ratslam/common/worker_pool.h"
#include "ratslam/vision/local_map.h"
#include "ratslam/vision/matching.h"

namespace ratslam {

struct TriangulationParams {
  double min_parallax_deg = 1.0;    ///< between the two rays that are farthest apart
  double max_error = 1.5;           ///< reprojection error, times the level's scale [px]
  double max_epipolar_error = 2.5;  ///< before the match is sharpened, times the level's scale [px]
  double spacing = 9.0;             ///< no new landmark nearer than this to an old one [px]
  int neighbours = 5;               ///< keyframes that a new landmark is looked for in
  int searched = 3;                 ///< the newest of them, whose features are searched for a first match
  int max_new = 300;                ///< landmarks a keyframe
};

struct View {
  RigidTransform T_camera_world;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted
  double sigma = 1.0;                               ///< relative
};

/// The point that several views see: linear start, then Gauss-Newton on the reprojection error.
/// @return nothing with fewer than two views, for parallel rays, or for a point behind a camera.
std::optional<Eigen::Vector3d> triangulate(const CameraModel& camera, const std::vector<View>& views);

/// Largest angle between the rays of a point to the views' centres [rad].
double parallax(const Eigen::Vector3d& point, const std::vector<View>& views);

/// Adds landmarks to the map for the newest keyframe. @param workers share the features. @return how many.
int addLandmarks(const CameraModel& camera, LocalMap& map, const TriangulationParams& params,
                 WorkerPool& workers);

}  // namespace ratslam
