/// Bundle adjustment of the local map's newest part.
///
/// The newest keyframes and the landmarks that they see are free. Older keyframes that see the same landmarks are
/// fixed, at least as many; they determine position and scale. An observation is removed only if it was an outlier in
/// two consecutive adjustments. So one bad step of the optimiser does not thin out the map.
#pragma once

#include "ratslam/vision/local_map.h"
#include "ratslam/vision/pose_refinement.h"

namespace ratslam {

struct WindowParams {
  int free_keyframes = 8;
  int fixed_keyframes = 12;
  int max_iterations = 5;
};

struct WindowSummary {
  int observations = 0;
  int removed = 0;     ///< number of observations removed
  double sigma = 0.0;  ///< scale of the reprojection errors after the adjustment [px]
};

/// Adjusts poses and positions in the map. With fewer than `free_keyframes` + 1 keyframes the oldest one is fixed.
WindowSummary adjustWindow(const CameraModel& camera, LocalMap& map, const WindowParams& params,
                           const RobustLoss& loss);

}  // namespace ratslam
