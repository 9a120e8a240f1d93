/// New landmarks from the features that a keyframe and its neighbours have in common.
///
/// Steps for each feature without a landmark:
///  1. Search its epipolar line in a neighbour by descriptor, and triangulate.
///  2. Align the feature's patch, warped according to that depth, to refine the match.
///  3. Align the same patch in the other neighbours at the projected position.
///  4. Triangulate from all views. Accept the landmark if the parallax is large enough and every reprojection error
///     is small.
/// Source: Hartley and Zisserman, Multiple View Geometry, ch. 12.
#pragma once

#include <optional>
#include <vector>

#include "ratslam/common/worker_pool.h"
#include "ratslam/vision/local_map.h"
#include "ratslam/vision/matching.h"

namespace ratslam {

struct TriangulationParams {
  double min_parallax_deg = 1.0;    ///< largest angle between two rays must be at least this
  double max_error = 1.5;           ///< reprojection error, times the level's scale [px]
  double max_epipolar_error = 2.5;  ///< before alignment, times the level's scale [px]
  double spacing = 9.0;             ///< least distance of a new landmark from an old one [px]
  int neighbours = 5;               ///< number of keyframes in which a new landmark is searched
  int searched = 3;                 ///< the newest of them, which are searched by descriptor
  int max_new = 300;                ///< new landmarks per keyframe
};

struct View {
  RigidTransform T_camera_world;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted
  double sigma = 1.0;                               ///< relative
};

/// Triangulates a point from several views: linear start, then Gauss-Newton on the reprojection error.
/// @return none with fewer than two views, for parallel rays, or for a point behind a camera.
std::optional<Eigen::Vector3d> triangulate(const CameraModel& camera, const std::vector<View>& views);

/// Largest angle between the rays of a point to the views' centres [rad].
double parallax(const Eigen::Vector3d& point, const std::vector<View>& views);

/// Adds landmarks of the newest keyframe to the map. @param workers share the features. @return their number.
int addLandmarks(const CameraModel& camera, LocalMap& map, const TriangulationParams& params,
                 WorkerPool& workers);

}  // namespace ratslam
