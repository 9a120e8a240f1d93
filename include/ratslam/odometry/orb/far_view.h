/// Motion between two images that no chain of others connects: after a gap, or where tracking was lost.
///
/// What lay far ahead before still looks the same after. Features are matched by descriptor over the whole
/// image; few matches remain, many of them wrong. So the motion is searched for where a vehicle can have
/// gone: a grid of turns about the vertical, each with the direction of its chord, and of pitch; the one whose
/// epipolar lines pass most matches wins. Rotation and direction are then refined on the Sampson distances
/// with Cauchy weights (Hartley and Zisserman, ch. 11). The length of the way stays unknown.
#pragma once

#include <optional>

#include "ratslam/odometry/orb/motion_history.h"
#include "ratslam/vision/frame.h"

namespace ratslam {

struct FarView {
  UncertainMotion motion;  ///< |translation| = 1; covariance of nothing along it
  int points = 0;          ///< matches that agree
};

/// @param predicted motion from before to after; the search goes three standard deviations to either side.
/// @param thorough extracts more features, for images far apart.
/// @return nothing where too few matches agree.
std::optional<FarView> compareFarFeatures(const CameraModel& camera, const Frame& before, const Frame& after,
                                          const UncertainMotion& predicted, bool thorough,
                                          WorkerPool& workers);

}  // namespace ratslam
