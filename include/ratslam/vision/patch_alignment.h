/// Where exactly a small piece of one image lies in another: affine-warped template alignment.
///
/// Inverse compositional Lucas-Kanade (Baker and Matthews, IJCV 2004) over translation; gain and offset of
/// brightness are eliminated by comparing patches with their means taken off and a fitted gain, so that
/// exposure changes do not move the result. The patch is warped by the affine map that the scene's geometry
/// predicts.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "ratslam/vision/image_pyramid.h"

namespace ratslam {

/// A place in one image and how its surroundings map into another.
struct PatchSource {
  const ImagePyramid* pyramid = nullptr;
  Eigen::Vector2d raw = Eigen::Vector2d::Zero();  ///< centre of the patch [raw px of level 0]
  int level = 0;                                  ///< at which its feature was found
};

struct PatchMatch {
  Eigen::Vector2d raw = Eigen::Vector2d::Zero();  ///< [raw px of level 0]
  int level = 0;                                  ///< of the pyramid in which it was measured
  double correlation = 0.0;                       ///< zero-mean normalised cross-correlation in [-1, 1]
};

struct AlignmentLimits {
  double max_shift = 3.0;  ///< from where the search starts [px of the level]
  double min_correlation = 0.85;
};

/// Aligns the patch in `target`, starting at `start` [raw px of level 0].
/// @param target_from_source derivative of target pixels by source pixels, both at level 0.
/// @return nothing if the patch leaves the image, has no texture in both directions, strays or does not look
/// alike.
std::optional<PatchMatch> alignPatch(const PatchSource& source, const ImagePyramid& target,
                                     const Eigen::Vector2d& start, const Eigen::Matrix2d& target_from_source,
                                     const AlignmentLimits& limits);

}  // namespace ratslam
