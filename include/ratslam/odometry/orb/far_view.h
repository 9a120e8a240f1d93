/// Motion between two images that no chain of others connects: after a gap, or while tracking was lost.
///
/// Features far ahead look the same in both images. Steps:
///  1. Match features by descriptor over the whole image. Few matches remain, and many of them are wrong.
///  2. Search the motions that a vehicle can make: a grid of turns about the vertical, each with the direction of
///     its chord, and of pitch. The motion whose epipolar lines pass most matches wins.
///  3. Refine rotation and direction on the Sampson distances with Cauchy weights (Hartley and Zisserman, ch. 11).
/// The length of the motion stays unknown.
#pragma once

#include <optional>

#include "ratslam/odometry/orb/motion_history.h"
#include "ratslam/vision/frame.h"

namespace ratslam {

struct FarView {
  UncertainMotion motion;  ///< |translation| = 1; the covariance is zero along it
  int points = 0;          ///< number of inlier matches
};

/// @param predicted motion from before to after; the search goes three standard deviations to either side.
/// @param thorough extracts more features, for images far apart.
/// @return none if too few matches agree.
std::optional<FarView> compareFarFeatures(const CameraModel& camera, const Frame& before, const Frame& after,
                                          const UncertainMotion& predicted, bool thorough,
                                          WorkerPool& workers);

}  // namespace ratslam
