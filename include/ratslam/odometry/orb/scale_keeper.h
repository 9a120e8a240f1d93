/// Keeps the odometry's unit of length constant, by means of the camera's height above the road.
///
/// Each keyframe's road plane (ground_plane.h) gives a measurement log(target height / measured height). The state
/// of a Kalman filter is the error of the log scale. It follows the measurements slowly, because a road is not flat
/// and the scale drifts by well under a per cent a metre. A measurement far from the prediction (a car, a kerb, a
/// crossing street) is left out. Only a long sequence of measurements that agree with each other restarts the
/// filter.
///
/// The filter also gives the uncertainty of the unit. Where roads are seen, the unit is anchored: its standard
/// deviation is the filter's, corrected by the size of the innovations, because a town's roads are flatter than a
/// track. Where no road is seen, the unit drifts as fast as the corrections so far show that it would.
///
/// If the camera height is unknown, the target is the height on which the first measurements agree: the unit is
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
  double road_sigma = 0.05;      ///< deviation of real roads from a plane, as error of log height
  double drift_sigma = 0.006;    ///< drift of the log scale from keyframe to keyframe
  double correlated = 4.0;       ///< number of neighbouring measurements that see the same piece of road
  double gate = 9.0;             ///< squared innovation of an outlier [sigma^2]
  int rejections_to_doubt = 25;  ///< consecutive outliers after which the filter restarts
};

class ScaleKeeper {
 public:
  /// @param normal of the road in camera axes when the vehicle stands level.
  ScaleKeeper(const ScaleParams& params, const Eigen::Vector3d& normal);

  /// Uses the map's newest keyframe. @return the factor by which the map is to be scaled; none if it is not.
  std::optional<double> update(const CameraModel& camera, const LocalMap& map);
  /// The factor from the arbitrary unit of a new map to the kept unit; none if no road is seen or no height is
  /// known yet.
  std::optional<double> scaleOfNewMap(const CameraModel& camera, const LocalMap& map);

  /// The camera's height in the odometry's unit; none before it is known.
  std::optional<double> targetHeight() const { return target_; }
  bool locked() const { return locked_; }
  /// Uncertainty of the unit.
  UnitOfLength unit() const;
  /// Standard deviation of the log of the present scale.
  double sigma() const;
  /// To be called if a new map got its scale without a road. @param sigma_log standard deviation of its log.
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
  double variance_ = 0.0;        // of the log scale's error, for roads as rough as assumed
  double surprise_ = 1.0;        // mean square of the innovations / their expected variance
  double start_variance_ = 0.0;  // variance at the start of the map, while not locked
  double unseen_ = 0.0;          // distance since the last measurement that was used
  double block_way_ = 0.0;       // length of the present block, over which corrections are summed
  double block_correction_ = 0.0;
  double blocks_way_ = 0.0;  // length of all blocks
  double blocks_squares_ = 0.0;
  int rejections_ = 0;
};

}  // namespace ratslam
