/// Refines the distortion coefficients of the camera from the landmarks (self-calibration).
///
/// A small error of the calibrated distortion distorts the landmarks. In every turn they cross the image, and the
/// unit of length changes with them: by 8 % a quarter turn for the published calibration of KITTI's images, which
/// is 7 px wrong at their corners. The error also shows in the reprojection errors, where it can be measured. A
/// distortion about another centre than the principal point looks like a slow turn; the tangential coefficients
/// describe it.
///
/// Steps:
///  1. Linearise the reprojection errors of a whole local map about its poses, its points and the lens model's
///     first two radial and its tangential coefficients.
///  2. Eliminate points and poses (Schur complement). What remains is the information about the coefficients.
///  3. Sum it over maps that share no keyframe, with a prior about the calibration, and solve. On a straight street
///     distortion looks much like depth, and small errors that all features share look like distortion. So only maps
///     that determine the lens well count: those of turns.
/// Source: Triggs et al., Bundle Adjustment - A Modern Synthesis (2000), on self-calibration. Focal length and
/// principal point are not refined: motion in a plane gives too little information about them.
#pragma once

#include <optional>

#include "ratslam/vision/bundle_adjustment.h"
#include "ratslam/vision/local_map.h"
#include "ratslam/vision/pose_refinement.h"

namespace ratslam {

/// Half the robust sum of squared errors as a function of a change c of the coefficients, minimised over poses
/// and points: gradient.c + c.hessian.c / 2. For coefficients that the lens model lacks all entries are zero.
struct LensInformation {
  Eigen::Matrix4d hessian = Eigen::Matrix4d::Zero();
  LensChange gradient = LensChange::Zero();
};

/// @param problem as for adjustBundle(), but all its poses count as free.
LensInformation measureLens(const CameraModel& camera, const BundleProblem& problem, const RobustLoss& loss);

struct LensRefinementParams {
  double radial_sigma = 0.03;       ///< prior standard deviation of the error of k1 and k2
  double tangential_sigma = 0.003;  ///< the same of p1 and p2
  double correlated = 10.0;         ///< number of observations that count as one, because their errors agree
  double worthwhile_shift = 0.5;    ///< least correction that is made, at the image's corners [px]
  /// A map counts if it determines the lens better than this, at the image's corners [px]. Errors that all features
  /// share shift a map's estimate in proportion to its variance: by 44 px for an exact camera on a straight street,
  /// whose maps have a deviation of 9 px. With 2 px, the shift is within the deviation.
  double usable_sigma = 2.0;
  /// Least chi-squared of the coefficients. It is high because on a straight road the errors of a map are less
  /// random than `correlated` allows for.
  double significance = 50.0;
  /// Largest correction per keyframe, at the image's corners, so that tracking continues [px].
  double shift_a_keyframe = 0.25;
};

class LensRefinement {
 public:
  LensRefinement(const CameraModel& calibrated, const LensRefinementParams& params)
      : calibrated_(calibrated), params_(params) {}

  /// To be called for each new keyframe. @return the refined camera; none if it has not changed.
  std::optional<CameraModel> update(const CameraModel& camera, const LocalMap& map, const RobustLoss& loss);
  /// Estimated change of the calibrated coefficients.
  LensChange estimate() const;

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("information", information_);
    fields("weighted", weighted_);
    fields("applied", applied_);
    fields("worthwhile", worthwhile_);
    fields("measured", measured_);
  }

 private:
  /// Standard deviation at the image's corners of coefficients about which this is known [px].
  double cornerSigma(Eigen::Matrix4d information) const;
  Eigen::Matrix4d informationWithPrior() const;
  double cornerShift(const LensChange& from, const LensChange& to) const;

  CameraModel calibrated_;
  LensRefinementParams params_;
  Eigen::Matrix4d information_ = Eigen::Matrix4d::Zero();
  LensChange weighted_ = LensChange::Zero();  // information times coefficients
  LensChange applied_ = LensChange::Zero();
  bool worthwhile_ = false;
  std::optional<KeyframeId> measured_;  // newest keyframe of the last local map that was used
};

}  // namespace ratslam
