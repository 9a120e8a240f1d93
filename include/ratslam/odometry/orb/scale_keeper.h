/// Keeps the odometry's unit of length constant, by means of the camera's height above the road.
///
/// Each patch of road that a keyframe sees (ground_plane.h) measures the height when the camera passes over it
/// (driven_road.h). Where the camera passes over none of them, the plane ahead is continued to the camera, which is far
/// less certain. A filter follows these measurements slowly (unit_filter.h), because a road is not flat and the unit
/// drifts by well under a per cent a metre. The first height above a new map comes from planes ahead that agree.
///
/// The filter also gives the uncertainty of the unit. Where roads are seen, the unit is anchored. Where none is seen, it
/// drifts as fast as the corrections so far show that it would.
///
/// If the camera height is unknown, the target is the height on which the first measurements agree: the unit is
/// arbitrary, but constant.
#pragma once

#include <deque>
#include <optional>

#include "ratslam/odometry/odometry.h"
#include "ratslam/odometry/orb/driven_road.h"
#include "ratslam/odometry/orb/ground_plane.h"
#include "ratslam/odometry/orb/unit_filter.h"
#include "ratslam/vision/local_map.h"

namespace ratslam {

struct ScaleParams {
  double camera_height = 0.0;   ///< [m]; 0 = unknown
  double driven_sigma = 0.007;  ///< error of log height above a patch of road passed over: bumps, suspension
  double road_sigma = 0.05;     ///< the same if the plane ahead is continued to the camera: slopes change
  UnitFilterParams filter;
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
    fields("target_is_guess", target_is_guess_);
    fields("locked", locked_);
    fields("pending", pending_);
    fields("driven", driven_);
    fields("filter", filter_);
    fields("start_variance", start_variance_);
    fields("way", way_);
    fields("undriven", undriven_);
  }

 private:
  std::optional<double> lock(double log_height);
  std::optional<double> correct(const std::vector<DrivenHeight>& heights,
                                const std::optional<RoadMeasurement>& road);
  double use(double log_error, double sigma_log, double road_sigma);

  ScaleParams params_;
  RoadParams road_;
  Eigen::Vector3d normal_;
  std::optional<double> target_;  // camera height in the odometry's unit, once it is known
  bool target_is_guess_ = false;  // from planes ahead alone
  bool locked_ = false;
  std::deque<double> pending_;  // log heights seen while not locked
  DrivenRoad driven_;
  UnitFilter filter_;
  double start_variance_ = 0.0;  // of the log scale at the start of the map, while not locked
  double way_ = 0.0;             // since the start of the map, while not locked
  double undriven_ = 0.0;        // way since the camera passed over a patch
};

}  // namespace ratslam
