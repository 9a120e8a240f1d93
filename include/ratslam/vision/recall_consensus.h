/// A first guess of a view's pose from matches of which many are wrong: consensus of minimal samples
/// (Fischler and Bolles 1981) with truncated costs (MSAC: Torr and Zisserman 2000).
///
/// - Epipolar: five matches give an essential matrix (Nister 2004), and of its four motions the one that puts
///   most points before both views is taken. The translation has unit length.
/// - Resection: three points of known inverse depth give a pose (P3P; Ke and Roumeliotis 2017). It has no
///   degenerate case where the views coincide or the scene is flat, and it keeps the unit of the depths.
///
/// Samples are drawn by a generator that starts anew in each call: the same matches give the same pose.
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
  double sigma = 1.0;                        ///< expected error of the difference of the two places
  std::optional<double> inverse_depth = {};  ///< in the anchor, where it is known
};

/// Distance at which the anchor's point appears from where the view has it, in sigmas; infinite behind the
/// view.
double recallError(const RecallView& view, const RecallPair& pair, double inverse_depth);

/// @return nothing where fewer than `min_inliers` pairs agree.
std::optional<RecallView> epipolarConsensus(const std::vector<RecallPair>& pairs, int min_inliers);

/// @param pairs those without inverse depth are left aside
/// @return nothing where fewer than `min_inliers` pairs agree.
std::optional<RecallView> resectionConsensus(const std::vector<RecallPair>& pairs, int min_inliers);

}  // namespace ratslam
