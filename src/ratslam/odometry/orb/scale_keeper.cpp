#include "ratslam/odometry/orb/scale_keeper.h"

#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

constexpr std::size_t kToLock = 5;      // number of measurements that must agree if the target is known
constexpr std::size_t kToLearn = 15;    // the same if they define the target
constexpr double kAgreement = 0.08;     // their largest median absolute deviation [log height]
constexpr double kNormalGain = 0.02;    // of the slow average of the road's normal
constexpr double kSurprises = 40.0;     // number of innovations in their mean square
constexpr double kLeastSurprise = 0.1;  // bound on the mean square: common errors do not show in innovations
constexpr double kBlock = 20.0;         // distance over which corrections are summed [heights]
constexpr double kPriorBlocks = 3.0;    // weight of the prior of the walk [blocks]
constexpr double kPriorWalk = 0.003;    // prior: random walk of the unit [1/sqrt(height)]
constexpr double kSeenLately = 60.0;    // the unit is anchored up to this distance after a road [heights]
constexpr double kLowestHeight = 0.02;  // range of the search, in median depths of the landmarks
constexpr double kHighestHeight = 0.5;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

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
    : params_(params), normal_(normal.normalized()) {
  if (params.camera_height > 0.0) target_ = params.camera_height;
}

double ScaleKeeper::walkVariance() const {
  const double unit = target_.value_or(1.0);
  const double prior_way = kPriorBlocks * kBlock * unit;
  const double prior = kPriorWalk * kPriorWalk / unit;
  return (prior * prior_way + blocks_squares_) / (prior_way + blocks_way_);
}

double ScaleKeeper::sigma() const {
  return std::sqrt((locked_ ? std::max(kLeastSurprise, surprise_) * variance_ : start_variance_) +
                   walkVariance() * unseen_);
}

UnitOfLength ScaleKeeper::unit() const {
  UnitOfLength unit;
  unit.walk_sigma = std::sqrt(walkVariance());
  if (locked_ && unseen_ < kSeenLately * *target_) unit.anchor_sigma = sigma();
  return unit;
}

void ScaleKeeper::move(const LocalMap& map) {
  const auto& keyframes = map.keyframes();
  const Frame& before = *keyframes[keyframes.size() - 2].frame;
  const double way = (keyframes.back().frame->centre() - before.centre()).norm();
  unseen_ += way;
  if (!locked_) return;
  block_way_ += way;
  if (block_way_ < kBlock * *target_) return;
  blocks_way_ += block_way_;
  blocks_squares_ += block_correction_ * block_correction_;
  block_way_ = block_correction_ = 0.0;
}

void ScaleKeeper::corrected(double log_factor) {
  unseen_ = 0.0;
  block_correction_ += log_factor;
}

std::optional<double> ScaleKeeper::scaleOfNewMap(const CameraModel& camera, const LocalMap& map) {
  locked_ = false;
  pending_.clear();
  unseen_ = block_way_ = block_correction_ = 0.0;
  start_variance_ = params_.road_sigma * params_.road_sigma;
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
  if (map.keyframes().size() < 2) return std::nullopt;
  move(map);
  const Frame& now = *map.keyframes().back().frame;
  if (!locked_) {
    const double depth = map.medianDepth(now.T_camera_world);
    const auto road = searchRoad(camera, now, earlierViews(map, 0.02 * depth, 0.06 * depth), normal_,
                                 kLowestHeight * depth, kHighestHeight * depth, road_);
    return road ? lock(std::log(road->plane.height)) : std::nullopt;
  }
  const auto road =
      measureRoad(camera, now, earlierViews(map, 0.3 * *target_, 0.9 * *target_), {normal_, *target_}, road_);
  return road ? filter(*road) : std::nullopt;
}

std::optional<double> ScaleKeeper::lock(double log_height) {
  const std::size_t needed = target_ ? kToLock : kToLearn;
  pending_.push_back(log_height);
  if (pending_.size() < needed) return std::nullopt;
  if (pending_.size() > needed) pending_.pop_front();
  const double middle = median({pending_.begin(), pending_.end()});
  std::vector<double> deviations;
  for (const double value : pending_) deviations.push_back(std::abs(value - middle));
  if (median(deviations) > kAgreement) return std::nullopt;
  locked_ = true;
  rejections_ = 0;
  pending_.clear();
  variance_ = params_.road_sigma * params_.road_sigma / 2.0;
  if (!target_) target_ = std::exp(middle);
  unseen_ = block_way_ = block_correction_ = 0.0;
  return *target_ / std::exp(middle);
}

std::optional<double> ScaleKeeper::filter(const RoadMeasurement& measurement) {
  variance_ += params_.drift_sigma * params_.drift_sigma;
  const double innovation = std::log(*target_ / measurement.plane.height);
  const double noise =
      measurement.sigma_log * measurement.sigma_log + params_.road_sigma * params_.road_sigma;
  if (innovation * innovation > params_.gate * (variance_ + noise)) {
    if (++rejections_ >= params_.rejections_to_doubt) locked_ = false;
    return std::nullopt;
  }
  rejections_ = 0;
  surprise_ += (innovation * innovation / (variance_ + noise) - surprise_) / kSurprises;
  const double gain = variance_ / (variance_ + params_.correlated * noise);
  variance_ *= 1.0 - gain;
  normal_ = (normal_ + kNormalGain * (measurement.plane.normal - normal_)).normalized();
  corrected(gain * innovation);
  return std::exp(gain * innovation);
}

}  // namespace ratslam
