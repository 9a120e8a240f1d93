/// Finding back into the local map without a prediction: descriptors of all landmarks against all features of
/// the frame, then the pose by AP3P within RANSAC (Ke and Roumeliotis, CVPR 2017; OpenCV), then tracking from
/// there.
#pragma once

#include "ratslam/odometry/orb/frame_tracker.h"

namespace ratslam {

/// As trackFrame, from nothing. @param min_inliers landmarks that must agree in the end.
TrackingOutcome relocalise(const CameraModel& camera, LocalMap& map, Frame& frame, int min_inliers,
                           const TrackingParams& params, WorkerPool& workers);

}  // namespace ratslam
