/// Locates frames that are older than a map in that map.
///
/// A new map contains landmarks that earlier frames saw from farther away. Going back from its first frame, each
/// older frame is tracked from its predicted pose. If that fails, for example across a gap, it is searched for by
/// descriptor (relocalisation.h). Frames between the map's first two keyframes are tracked from either.
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
  int search_inliers = 25;  ///< inliers that a frame found by search must have
};

/// @param frames in any order, before or soon after the map's first keyframe. @param velocity left increment of
/// the camera's pose per second at that keyframe. @return the frames that were found, in ascending order of stamps.
std::vector<LocatedFrame> lookBack(const CameraModel& camera, const LocalMap& map,
                                   std::vector<std::shared_ptr<const Frame>> frames, const Vector6& velocity,
                                   const LookingBackParams& params, WorkerPool& workers);

/// Locates one earlier frame if rotation and direction from it to the map's first keyframe are known better than
/// the distance: tries distances within three standard deviations.
/// @param to_first motion from the frame to that keyframe. @return none if the frame is not found, or if its
/// rotation is known too poorly for a search.
std::optional<PoseEstimate> findAlong(const CameraModel& camera, const LocalMap& map, const Frame& frame,
                                      const UncertainMotion& to_first, const LookingBackParams& params,
                                      WorkerPool& workers);

}  // namespace ratslam
