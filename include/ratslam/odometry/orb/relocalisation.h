/// Relocalisation in the local map without a prediction.
///
/// 1. Match the descriptors of all landmarks with all features of the frame.
/// 2. Estimate the pose by AP3P within RANSAC (Ke and Roumeliotis, CVPR 2017; OpenCV).
/// 3. Track the local map from there.
#pragma once

#include "ratslam/odometry/orb/frame_tracker.h"

namespace ratslam {

/// Like trackFrame, without a prediction. @param min_inliers landmarks that must agree in the end.
TrackingOutcome relocalise(const CameraModel& camera, LocalMap& map, Frame& frame, int min_inliers,
                           const TrackingParams& params, WorkerPool& workers);

}  // namespace ratslam
