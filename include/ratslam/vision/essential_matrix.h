/// Essential matrix E between two views: b' E a = 0 for the bearings a and b of a point in the first and second view.
///
/// - From five matches: Stewenius, Engels and Nister, "Recent developments on direct relative orientation" (2006).
/// - From many matches with outliers: consensus of samples of five (consensus.h).
/// - Its four motions: Hartley and Zisserman, "Multiple View Geometry" (2004), result 9.19.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ratslam/vision/consensus.h"
#include "ratslam/vision/rigid_transform.h"

namespace ratslam {

/// A match between two views.
struct BearingPair {
  Eigen::Vector2d first = Eigen::Vector2d::Zero();  ///< (X/Z, Y/Z)
  Eigen::Vector2d second = Eigen::Vector2d::Zero();
  double sigma = 1.0;  ///< expected error of the difference of the two bearings
};

/// @return E of norm 1; none if fewer than `min_inliers` pairs, or fewer than six, agree.
std::optional<Eigen::Matrix3d> essentialConsensus(const std::vector<BearingPair>& pairs, int min_inliers,
                                                  const ConsensusParams& params);

/// The four possible motions from the first to the second view: rotation and unit translation. The points decide
/// between them.
std::vector<RigidTransform> decomposeEssential(const Eigen::Matrix3d& essential);

}  // namespace ratslam
