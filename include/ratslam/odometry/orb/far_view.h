/// Motion between two images that no chain of others connects: after a gap, or where tracking was lost.
///
/// What lay far ahead before still looks the same after: features are matched by descriptor over the whole
/// image; an essential matrix (two_view.h) gives the first guess; rotation and direction are then refined
/// together with the points (bundle_adjustment.h). The length of the way stays unknown.
#pragma once

#include <optional>

#include "ratslam/vision/frame.h"

namespace ratslam {

struct FarView {
  RigidTransform T_after_before;  ///< |translation| = 1
  double rotation_sigma = 0.0;    ///< [rad] about each axis
  double direction_sigma = 0.0;   ///< [rad]
  int points = 0;                 ///< that agree
};

/// @return nothing where too few features agree, or where the camera has hardly moved.
std::optional<FarView> compareFarFeatures(const CameraModel& camera, const Frame& before, const Frame& after);

}  // namespace ratslam
