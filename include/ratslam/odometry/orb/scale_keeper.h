/// Keeps the odometry's unit of length constant by the one length that does not change: the camera's height
/// above the road.
///
/// Each keyframe's road plane (ground_plane.h) gives log(target height / measured height); a Kalman filter
/// whose state is the error of the log scale follows it slowly, because a road is not flat and a scale drifts
/// by well under a per cent a metre. A measurement far from what the filter expects - a car, a kerb, a
/// crossing street
/// - is left out; only a long row of measurements that agree with each other may overrule it.
///
/// How well the unit is known follows from the same: anchored, with the filter's deviation - corrected by how
/// large the innovations really are, for a town's roads are flatter than a track's - where roads are seen; and where they are not it drifts as it would have drifted without the corrections made so far.
///
/// Without a known camera height the target is what the first measurements agree on: the unit stays
/// arbitrary, but constant.
#pragma once

#include <deque>
#include <optional>

#include "ratslam/odometry/odometry.h"
#include "ratslam/odometry/orb/ground_plane.h"
#include "ratslam/vision/local_map.h"

namespace ratslam {

struct ScaleParams {
  double camera_height = 0.0;    ///< [m]; 0 = unknown
  double road_sigma = 0.05;      ///< how far real roads depart from a plane, as error of log height
  double drift_sigma = 0.006;    ///< of the log scale from keyframe to keyframe
  double correlated = 4.0;       ///< so many neighbouring measurements see the same piece of road
  double gate = 9.0;             ///< squared innovation of an outlier [sigma^2]
  int rejections_to_doubt = 25;  ///< in a row, before the filter starts over
};

class ScaleKeeper {
 public:
  /// @param normal of the road in camera axes when the vehicle stands level.
  ScaleKeeper(const ScaleParams& params, const Eigen::Vector3d& normal);

  /// Looks at the map's newest keyframe. @return the factor by which the map is to be scaled, where there is
  /// one.
  std::optional<double> update(const CameraModel& camera, const LocalMap& map);
  /// The factor that brings a new map of arbitrary unit to the kept one; nothing where no road is seen, or
  /// where no height is known yet.
  std::optional<double> scaleOfNewMap(const CameraModel& camera, const LocalMap& map);

  /// The camera's height in the odometry's unit; nothing before it is known.
  std::optional<double> targetHeight() const { return target_; }
  bool locked() const { return locked_; }
  /// How well the unit is known.
  UnitOfLength unit() const;
  /// Standard deviation of the log of the present scale.
  double sigma() const;
  /// A new map has got its scale without a road. @param sigma_log its standard deviation.
  void scaleGiven(double sigma_log) { start_variance_ = sigma_log * sigma_log; }

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("normal", normal_);
    fields("target", target_);
    fields("locked", locked_);
    fields("pending", pending_);
    fields("variance", variance_);
    fields("surprise", surprise_);
    fields("start_variance", start_variance_);
    fields("unseen", unseen_);
    fields("block_way", block_way_);
    fields("block_correction", block_correction_);
    fields("blocks_way", blocks_way_);
    fields("blocks_squares", blocks_squares_);
    fields("rejections", rejections_);
  }

 private:
  void move(const LocalMap& map);
  void corrected(double log_factor);
  double walkVariance() const;
  std::optional<double> lock(double log_height);
  std::optional<double> filter(const RoadMeasurement& measurement);

  ScaleParams params_;
  RoadParams road_;
  Eigen::Vector3d normal_;
  std::optional<double> target_;
  bool locked_ = false;
  std::deque<double> pending_;   // log heights seen while not locked
  double variance_ = 0.0;        // of the log scale's error, if roads are as rough as assumed
  double surprise_ = 1.0;        // mean square of the innovations over what was expected
  double start_variance_ = 0.0;  // the same while not locked, when the map was new
  double unseen_ = 0.0;          // way since the last measurement that counted
  double block_way_ = 0.0;       // of the present block, over which corrections are summed
  double block_correction_ = 0.0;
  double blocks_way_ = 0.0;  // of all blocks
  double blocks_squares_ = 0.0;
  int rejections_ = 0;
};

}  // namespace ratslam
