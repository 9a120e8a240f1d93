/// Alignment of a small patch of one image in another image, to a fraction of a pixel.
///
/// The method is inverse compositional Lucas-Kanade (Baker and Matthews, IJCV 2004) over translation. The patch is
/// first warped by the affine map that the scene's geometry predicts. Patches are compared without their means and
/// with a fitted gain, so that changes of exposure do not move the result.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ratslam/vision/image_pyramid.h"

namespace ratslam {

/// Centre of the patch in the source image.
struct PatchSource {
  const ImagePyramid* pyramid = nullptr;
  Eigen::Vector2d raw = Eigen::Vector2d::Zero();  ///< centre of the patch [raw px of level 0]
  int level = 0;                                  ///< pyramid level of its feature
};

struct PatchMatch {
  Eigen::Vector2d raw = Eigen::Vector2d::Zero();  ///< [raw px of level 0]
  int level = 0;                                  ///< of the pyramid in which it was measured
  double correlation = 0.0;                       ///< zero-mean normalised cross-correlation in [-1, 1]
};

struct AlignmentLimits {
  double max_shift = 3.0;  ///< from the start of the search [px of the level]
  double min_correlation = 0.85;
};

/// Aligns the patch in `target`, starting at `start` [raw px of level 0].
/// @param target_from_source derivative of target pixels by source pixels, both at level 0.
/// @return none if the patch leaves the image, lacks texture in a direction, moves too far or is not similar enough.
std::optional<PatchMatch> alignPatch(const PatchSource& source, const ImagePyramid& target,
                                     const Eigen::Vector2d& start, const Eigen::Matrix2d& target_from_source,
                                     const AlignmentLimits& limits);

}  // namespace ratslam
