/// The lens error that a camera's calibration has left, found from the landmarks themselves.
///
/// A monocular odometry whose lens bends rays a little more than its calibration says fits its landmarks all
/// the same, by stretching them: in every turn landmarks cross the image, and the unit of length changes with
/// them (by 8 % a quarter turn for the published calibration of KITTI's images, 7 px at their corners). The
/// bend shows in the reprojection errors, too, and there it can be measured. A bend about another centre than
/// the principal point looks like a slow turn in the same way; the tangential coefficients stand for it.
///
/// Steps: linearise the reprojection errors of a whole local map about its poses, its points and the lens
/// model's first radial and its tangential coefficients; eliminate points and poses (Schur complement), which
/// leaves what that map knows about the coefficients; sum over maps that share no keyframe, with a prior that
/// trusts the calibration; solve. Triggs et al., Bundle Adjustment - A Modern Synthesis (2000), on
/// self-calibration. Focal length and principal point stay: driving on a plane says too little about them.
#pragma once

#include <optional>

#include "ratslam/vision/bundle_adjustment.h"
#include "ratslam/vision/local_map.h"
#include "ratslam/vision/pose_refinement.h"

namespace ratslam {

/// Half the robust sum of squared errors near a change c of the coefficients, with poses and points free:
/// gradient.c + c.hessian.c / 2. Nothing is known of coefficients that the lens model lacks.
struct LensInformation {
  Eigen::Matrix4d hessian = Eigen::Matrix4d::Zero();
  LensChange gradient = LensChange::Zero();
};

/// @param problem one that adjustBundle() takes; all its poses count as free.
LensInformation measureLens(const CameraModel& camera, const BundleProblem& problem, const RobustLoss& loss);

struct LensRefinementParams {
  double radial_sigma = 0.03;       ///< how far calibrated coefficients are off, k1 and k2
  double tangential_sigma = 0.003;  ///< p1 and p2
  double correlated = 10.0;         ///< so many observations of a map err alike
  double worthwhile_shift = 0.5;    ///< at the image's corners; a smaller correction is not made [px]
  double significance = 50.0;       ///< least chi-squared of the coefficients: on a straight road errors of
                                    ///< a map are less random than `correlated` says
  double shift_a_keyframe =
      0.25;  ///< the most a correction moves the corners by, so that tracking holds [px]
};

class LensRefinement {
 public:
  LensRefinement(const CameraModel& calibrated, const LensRefinementParams& params)
      : calibrated_(calibrated), params_(params) {}

  /// To be called for each new keyframe. @return the camera to use from now on, where it has changed.
  std::optional<CameraModel> update(const CameraModel& camera, const LocalMap& map, const RobustLoss& loss);
  /// What to add to the calibrated coefficients, by all that is known.
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
  Eigen::Matrix4d informationWithPrior() const;
  double cornerShift(const LensChange& from, const LensChange& to) const;

  CameraModel calibrated_;
  LensRefinementParams params_;
  Eigen::Matrix4d information_ = Eigen::Matrix4d::Zero();
  LensChange weighted_ = LensChange::Zero();  // information times coefficients
  LensChange applied_ = LensChange::Zero();
  bool worthwhile_ = false;
  std::optional<KeyframeId> measured_;  // newest keyframe of the last map that was measured
};

}  // namespace ratslam
