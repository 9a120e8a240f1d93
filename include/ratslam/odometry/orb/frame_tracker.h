/// Pose of a new frame against the local map.
///
/// Steps:
///  1. Search the landmarks of the last frame by descriptor around their predicted positions, in a window that
///     grows until enough are found. Refine the pose.
///  2. Align every landmark in view to a fraction of a pixel, and refine the pose on them again.
#pragma once

#include <vector>

#include "ratslam/common/worker_pool.h"
#include "ratslam/vision/local_map.h"
#include "ratslam/vision/patch_alignment.h"
#include "ratslam/vision/pose_refinement.h"

namespace ratslam {

struct TrackingParams {
  int min_tracked = 25;  ///< with fewer landmarks tracking has failed
  RobustLoss loss;
  AlignmentLimits alignment;
};

struct TrackingOutcome {
  bool tracked = false;
  PoseEstimate estimate;
  int in_view = 0;  ///< landmarks that the pose projects into the image
};

/// On success sets the frame's pose and observations (inliers only), and updates how often landmarks were visible
/// and found.
/// @param last observations of the frame before. @param workers share the landmarks.
TrackingOutcome trackFrame(const CameraModel& camera, LocalMap& map, const std::vector<Observation>& last,
                           const RigidTransform& predicted, Frame& frame, const TrackingParams& params,
                           WorkerPool& workers);

/// Step 2 of trackFrame alone. @param pose right to a few pixels.
TrackingOutcome trackLocalMap(const CameraModel& camera, LocalMap& map, const RigidTransform& pose,
                              Frame& frame, const TrackingParams& params, WorkerPool& workers);

}  // namespace ratslam
