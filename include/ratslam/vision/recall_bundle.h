/// Bundle adjustment of one or two views against an anchor view: Triggs et al., "Bundle adjustment - a modern
/// synthesis" (2000), with points as inverse depths in the anchor (Civera et al., 2008).
///
/// A point with bearing b = (x, y, 1) and inverse depth rho in the anchor appears in a view at pi(R b + rho t), where
/// X_view = R X_anchor + t. Points at infinity (rho = 0) are no special case. A point that only one view shares with
/// the anchor still constrains the view by its epipolar line.
///
/// 1. Levenberg-Marquardt over the views' poses with Cauchy weights; the points are eliminated (Schur complement).
/// 2. Observations beyond the gate become outliers. Repeat from 1; outliers may become inliers again.
/// 3. Covariance of the poses: the inverse of the reduced Hessian times the variance of the residuals.
///
/// Gauge: at least one view has a translation of fixed length or none. All lengths are in its unit.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace ratslam {

/// Free part of a view's pose.
enum class RecallMotion {
  kRotation,  ///< no translation: rotation only
  kUnit,      ///< |t| stays 1
  kFree
};

struct RecallView {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  ///< X_view = R X_anchor + t
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
  RecallMotion motion = RecallMotion::kFree;
};

struct RecallObservation {
  int view = 0;
  int point = 0;
  Eigen::Vector2d bearing = Eigen::Vector2d::Zero();  ///< (X/Z, Y/Z) in the view
  double sigma = 1.0;                                 ///< expected error of `bearing`
  bool inlier = true;
};

struct RecallPoint {
  Eigen::Vector2d bearing = Eigen::Vector2d::Zero();  ///< (X/Z, Y/Z) in the anchor
  double inverse_depth = 0.0;                         ///< 1 / Z in the anchor
  double sigma = 0.0;  ///< of inverse_depth for known poses; infinite if no observation determines it
};

struct RecallBundle {
  std::vector<RecallView> views;
  std::vector<RecallPoint> points;
  std::vector<RecallObservation> observations;
};

/// Most likely inverse depth, in [0, inf), of a point seen in the anchor and in one view (least squares,
/// iterated).
double inverseDepth(const RecallView& view, const Eigen::Vector2d& anchor, const Eigen::Vector2d& bearing);

/// Refines views and points and marks outliers. Inverse depths need a sensible start (inverseDepth). At most two
/// views. @return covariance of all views, 6 rows per view (rotation, translation), as increments from the left:
/// R <- exp(dr) R, t <- t + dt. None if too few observations agree to determine the poses.
std::optional<Eigen::MatrixXd> refineRecallBundle(RecallBundle& bundle);

/// Number of inliers among the observations of a view.
int inlierCount(const RecallBundle& bundle, int view);

}  // namespace ratslam
