/// Where frames from before a map began lie in it.
///
/// A map that has just begun shows places that earlier frames saw from farther away. Going back from its first
/// frame each older one is tracked from where the camera's motion puts it, and searched for by descriptor
/// (relocalisation.h) where that fails, as across a gap.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ratslam/odometry/orb/frame_tracker.h"
#include "ratslam/odometry/orb/motion_history.h"

namespace ratslam {

struct LocatedFrame {
  Stamp stamp = 0;
  PoseEstimate estimate;
};

struct LookingBackParams {
  TrackingParams tracking;
  int search_inliers = 25;  ///< that a frame must show where it was searched for
};

/// @param map whose first keyframe is where the camera was at `begin`. @param frames in any order, before or
/// soon after that keyframe. @param velocity left increment of the camera's pose per second at that keyframe.
/// @return those that were found, in ascending order of stamps.
std::vector<LocatedFrame> lookBack(const CameraModel& camera, const LocalMap& map,
                                   std::vector<std::shared_ptr<const Frame>> frames, const Vector6& velocity,
                                   const LookingBackParams& params, WorkerPool& workers);

/// Looks for one earlier frame where rotation and direction from it to the map's first keyframe are known
/// better than the length of the way: tries lengths within three standard deviations.
/// @param to_first from the frame to that keyframe. @return nothing where the frame is not found, or where its
/// rotation is known too poorly to be looked for.
std::optional<PoseEstimate> findAlong(const CameraModel& camera, const LocalMap& map, const Frame& frame,
                                      const UncertainMotion& to_first, const LookingBackParams& params,
                                      WorkerPool& workers);

}  // namespace ratslam
