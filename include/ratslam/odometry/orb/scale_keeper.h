/// Keeps the odometry's unit of length constant by the one length that does not change: the camera's height
/// above the road.
///
/// Each keyframe's road plane (ground_plane.h) gives log(target height / measured height); a Kalman filter
/// whose state is the error of the log scale follows it slowly, because a road is not flat and a scale drifts
/// by well under a per cent a metre. A measurement far from what the filter expects - a car, a kerb, a
/// crossing street
/// - is left out; only a long row of measurements that agree with each other may overrule it.
///
/// Without a known camera height the target is what the first measurements agree on: the unit stays
/// arbitrary, but constant.
#pragma once

#include <deque>
#include <optional>

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
  std::optional<RoadMeasurement> lastMeasurement() const { return last_; }

 private:
  std::optional<double> lock(double log_height);
  std::optional<double> filter(const RoadMeasurement& measurement);

  ScaleParams params_;
  RoadParams road_;
  Eigen::Vector3d normal_;
  std::optional<double> target_;
  bool locked_ = false;
  std::deque<double> pending_;  // log heights seen while not locked
  double variance_ = 0.0;       // of the log scale's error
  int rejections_ = 0;
  std::optional<RoadMeasurement> last_;
};

}  // namespace ratslam
