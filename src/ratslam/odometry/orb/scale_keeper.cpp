#include "ratslam/odometry/orb/scale_keeper.h"

#include <algorithm>
#include <cmath>

#include "ratslam/common/statistics.h"

namespace ratslam {
namespace {

constexpr std::size_t kToLock = 5;      // number of measurements that must agree if the target is known
constexpr std::size_t kToLearn = 15;    // the same if they define the target
constexpr double kAgreement = 0.08;     // their largest median absolute deviation [log height]
constexpr double kHeightError = 0.006;  // of a height measured by hand: 1 cm in 1.65 m
constexpr double kNormalGain = 0.02;    // of the slow average of the road's normal
constexpr double kSeenLately = 60.0;    // the unit is anchored up to this distance after a road [heights]
constexpr double kNotDriven = 20.0;     // without a patch for so long, the plane ahead counts [heights]
constexpr double kLowestHeight = 0.02;  // range of the search, in median depths of the landmarks
constexpr double kHighestHeight = 0.5;

/// Earlier keyframes that see the same road: for each of two baselines the nearest one that has at least it.
std::vector<const Frame*> earlierViews(const LocalMap& map, double short_baseline, double long_baseline) {
  const auto& keyframes = map.keyframes();
  const Eigen::Vector3d here = keyframes.back().frame->centre();
  std::vector<const Frame*> views;
  double wanted = short_baseline;
  for (std::size_t i = keyframes.size() - 1; i-- > 0 && views.size() < 2;) {
    const double baseline = (keyframes[i].frame->centre() - here).norm();
    if (baseline > 2.0 * long_baseline) break;
    if (baseline < wanted) continue;
    views.push_back(keyframes[i].frame.get());
    wanted = std::max(long_baseline, 1.2 * baseline);
  }
  return views;
}

}  // namespace

ScaleKeeper::ScaleKeeper(const ScaleParams& params, const Eigen::Vector3d& normal)
    : params_(params), normal_(normal.normalized()), filter_(params.filter) {
  if (params.camera_height > 0.0) target_ = params.camera_height;
  filter_.start(target_.value_or(1.0));
}

double ScaleKeeper::sigma() const {
  return locked_ ? filter_.sigma() : std::sqrt(start_variance_ + filter_.walkVariance() * way_);
}

UnitOfLength ScaleKeeper::unit() const {
  UnitOfLength unit;
  unit.walk_sigma = std::sqrt(filter_.walkVariance());
  if (locked_ && filter_.unseen() < kSeenLately * *target_) unit.anchor_sigma = sigma();
  if (params_.camera_height > 0.0) unit.constant_sigma = kHeightError;
  return unit;
}

std::optional<double> ScaleKeeper::scaleOfNewMap(const CameraModel& camera, const LocalMap& map) {
  locked_ = false;
  pending_.clear();
  way_ = 0.0;
  start_variance_ = square(params_.road_sigma);
  if (!target_ || map.keyframes().size() < 2) return std::nullopt;
  const Frame& now = *map.keyframes().back().frame;
  const double depth = map.medianDepth(now.T_camera_world);
  const Frame* first = map.keyframes().front().frame.get();
  const auto road =
      searchRoad(camera, now, {first}, normal_, kLowestHeight * depth, kHighestHeight * depth, road_);
  if (!road) return std::nullopt;
  return *target_ / road->plane.height;
}

std::optional<double> ScaleKeeper::update(const CameraModel& camera, const LocalMap& map) {
  const auto& keyframes = map.keyframes();
  if (keyframes.size() < 2) return std::nullopt;
  const Frame& now = *keyframes.back().frame;
  const RigidTransform T_now_before =
      now.T_camera_world * keyframes[keyframes.size() - 2].frame->T_camera_world.inverse();
  const double way = T_now_before.translation.norm();
  if (!locked_) {
    way_ += way;
    const double depth = map.medianDepth(now.T_camera_world);
    const auto road = searchRoad(camera, now, earlierViews(map, 0.02 * depth, 0.06 * depth), normal_,
                                 kLowestHeight * depth, kHighestHeight * depth, road_);
    return road ? lock(std::log(road->plane.height)) : std::nullopt;
  }
  filter_.move(way);
  undriven_ += way;
  std::vector<DrivenHeight> heights = driven_.moveOn(T_now_before, *target_);
  const auto road =
      measureRoad(camera, now, earlierViews(map, 0.3 * *target_, 0.9 * *target_), {normal_, *target_}, road_);
  if (road) {
    if (const auto driven = driven_.add(*road)) heights.push_back(*driven);
  }
  return correct(heights, road);
}

std::optional<double> ScaleKeeper::correct(const std::vector<DrivenHeight>& heights,
                                           const std::optional<RoadMeasurement>& road) {
  if (!heights.empty()) undriven_ = 0.0;
  double log_factor = 0.0;
  for (const DrivenHeight& driven : heights) {
    log_factor +=
        use(std::log(*target_ / driven.height) - log_factor, driven.sigma_log, params_.driven_sigma);
  }
  if (road) {
    const double log_error = std::log(*target_ / road->plane.height);
    const double variance = square(road->sigma_log) + square(params_.road_sigma);
    // A car ahead or a wall must not become the road's normal.
    if (filter_.expects(log_error, variance)) {
      normal_ = (normal_ + kNormalGain * (road->plane.normal - normal_)).normalized();
    }
    if (undriven_ > kNotDriven * *target_) {
      log_factor += use(log_error - log_factor, road->sigma_log, params_.road_sigma);
    }
  }
  if (filter_.lost()) {
    locked_ = false;
    way_ = 0.0;
    start_variance_ = square(params_.filter.start_sigma);
  }
  if (log_factor == 0.0) return std::nullopt;
  driven_.rescale(std::exp(log_factor));
  return std::exp(log_factor);
}

/// Uses one measurement. @return log of the factor by which the unit is to be corrected
double ScaleKeeper::use(double log_error, double sigma_log, double road_sigma) {
  const bool starting = filter_.starting();
  const double correction = filter_.use(log_error, square(sigma_log) + square(road_sigma));
  if (!starting || filter_.starting() || !target_is_guess_) return correction;
  // The unit is arbitrary, so the better height becomes the target, and the unit stays.
  *target_ *= std::exp(-correction);
  target_is_guess_ = false;
  return 0.0;
}

std::optional<double> ScaleKeeper::lock(double log_height) {
  const std::size_t needed = target_ ? kToLock : kToLearn;
  pending_.push_back(log_height);
  if (pending_.size() < needed) return std::nullopt;
  if (pending_.size() > needed) pending_.pop_front();
  const std::vector<double> latest(pending_.begin(), pending_.end());
  const double middle = median(latest);
  if (medianDeviation(latest, middle) > kAgreement) return std::nullopt;
  locked_ = true;
  pending_.clear();
  if (!target_) {
    target_ = std::exp(middle);
    target_is_guess_ = true;
  }
  driven_.clear();
  undriven_ = 0.0;
  filter_.start(*target_);
  return *target_ / std::exp(middle);
}

}  // namespace ratslam
