/// First estimate of a view's pose from matches with many outliers, by consensus of minimal samples (consensus.h).
///
/// - Epipolar: the essential matrix (essential_matrix.h). Of its four motions the one with most points in front of both
///   views is taken. The translation has unit length.
/// - Resection: three points of known inverse depth give a pose (P3P; Ke and Roumeliotis 2017). Coinciding views and
///   flat scenes are no degenerate cases. The result has the unit of the depths.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "ratslam/vision/recall_bundle.h"

namespace ratslam {

/// A match between the anchor and a view.
struct RecallPair {
  Eigen::Vector2d anchor = Eigen::Vector2d::Zero();  ///< bearings (X/Z, Y/Z)
  Eigen::Vector2d bearing = Eigen::Vector2d::Zero();
  double sigma = 1.0;                        ///< expected error of the difference of the two bearings
  std::optional<double> inverse_depth = {};  ///< in the anchor; none if unknown
};

/// Distance of the anchor's projected point from its bearing in the view [sigma]; infinite behind the view.
double recallError(const RecallView& view, const RecallPair& pair, double inverse_depth);

/// @return none if fewer than `min_inliers` pairs agree.
std::optional<RecallView> epipolarConsensus(const std::vector<RecallPair>& pairs, int min_inliers);

/// @param pairs those without inverse depth are not used
/// @return none if fewer than `min_inliers` pairs agree.
std::optional<RecallView> resectionConsensus(const std::vector<RecallPair>& pairs, int min_inliers);

}  // namespace ratslam
