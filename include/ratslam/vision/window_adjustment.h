/// Bundle adjustment of the local map's newest part.
///
/// Free: the newest keyframes and the landmarks they see. Fixed: older keyframes that see the same landmarks,
/// at least as many again; they hold position and scale. An observation is dropped only after it was found
/// wrong in two adjustments in a row, so that one bad step of an eager optimiser does not thin out the map.
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
  int removed = 0;     ///< observations dropped
  double sigma = 0.0;  ///< scale of the reprojection errors after the adjustment [px]
};

/// Adjusts poses and positions in the map. With fewer keyframes than `free_keyframes` + 1 the oldest one is
/// fixed.
WindowSummary adjustWindow(const CameraModel& camera, LocalMap& map, const WindowParams& params,
                           const RobustLoss& loss);

}  // namespace ratslam
