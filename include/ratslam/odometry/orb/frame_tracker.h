/// Pose of a new frame against the local map.
///
/// Steps: the landmarks of the last frame are searched by descriptor around where a predicted pose puts them,
/// in a window that grows until enough are found; the pose is refined; then every landmark in view is aligned
/// to a fraction of a pixel, and the pose is refined again on those.
#pragma once

#include <vector>

#include "ratslam/common/worker_pool.h"
#include "ratslam/vision/local_map.h"
#include "ratslam/vision/patch_alignment.h"
#include "ratslam/vision/pose_refinement.h"

namespace ratslam {

struct TrackingParams {
  int min_tracked = 25;  ///< landmarks below which tracking has failed
  RobustLoss loss;
  AlignmentLimits alignment;
};

struct TrackingOutcome {
  bool tracked = false;
  PoseEstimate estimate;
  int in_view = 0;  ///< landmarks that the pose predicts in the image
};

/// On success sets the frame's pose and observations (inliers only) and counts landmarks as visible and
/// found.
/// @param last observations of the frame before. @param workers share the landmarks.
TrackingOutcome trackFrame(const CameraModel& camera, LocalMap& map, const std::vector<Observation>& last,
                           const RigidTransform& predicted, Frame& frame, const TrackingParams& params,
                           WorkerPool& workers);

/// The second half of trackFrame by itself: from a pose that is right to a few pixels.
TrackingOutcome trackLocalMap(const CameraModel& camera, LocalMap& map, const RigidTransform& pose,
                              Frame& frame, const TrackingParams& params, WorkerPool& workers);

}  // namespace ratslam
