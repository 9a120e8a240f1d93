#include "ratslam/odometry/orb/unit_filter.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "ratslam/common/statistics.h"

namespace ratslam {
namespace {

constexpr std::size_t kToStart = 5;      // measurements whose median begins
constexpr std::size_t kToChange = 8;     // outliers in a row that show a change of the unit if they agree ...
constexpr double kPiecesToChange = 2.0;  // ... over so many pieces of road without any other measurement
constexpr double kPiecesToLose = 6.0;    // pieces of road after which outliers that do not agree make it lost
constexpr double kSurprises = 40.0;      // number of innovations in their mean square
constexpr double kLeastSurprise = 0.1;   // bound on the mean square: common errors do not show in innovations
constexpr double kBlock = 20.0;          // length over which corrections are summed [heights]
constexpr double kPriorBlocks = 3.0;     // weight of the prior of the walk [blocks]
constexpr double kPriorWalk = 0.003;     // prior: standard deviation of the walk [1/sqrt(height)]

}  // namespace

void UnitFilter::start(double height) {
  height_ = height;
  starting_ = true;
  lost_ = false;
  collected_.clear();
  variance_ = square(params_.start_sigma);
  unseen_ = doubted_ = block_way_ = block_correction_ = 0.0;
}

void UnitFilter::move(double way) {
  unseen_ += way;
  if (!collected_.empty()) doubted_ += way;
  if (starting_) return;
  block_way_ += way;
  if (block_way_ < kBlock * height_) return;
  blocks_way_ += block_way_;
  blocks_squares_ += square(block_correction_);
  block_way_ = block_correction_ = 0.0;
}

double UnitFilter::walkVariance() const {
  const double prior_way = kPriorBlocks * kBlock * height_;
  const double prior = square(kPriorWalk) / height_;
  return (prior * prior_way + blocks_squares_) / (prior_way + blocks_way_);
}

double UnitFilter::sigma() const {
  const double known = starting_ ? variance_ : std::max(kLeastSurprise, surprise_) * variance_;
  return std::sqrt(known + walkVariance() * unseen_);
}

bool UnitFilter::expects(double log_error, double variance) const {
  return square(log_error) <= params_.gate * (predictedVariance() + std::max(1.0, surprise_) * variance);
}

double UnitFilter::use(double log_error, double variance) {
  if (lost_) return 0.0;
  if (starting_) {
    collected_.push_back(log_error);
    return collected_.size() < kToStart ? 0.0 : finishStart();
  }
  if (!expects(log_error, variance)) return doubt(log_error, variance);
  collected_.clear();
  doubted_ = 0.0;
  surprise_ += (square(log_error) / (predictedVariance() + variance) - surprise_) / kSurprises;
  const double correction = take(log_error, variance);
  block_correction_ += correction;
  return correction;
}

/// Adds an outlier. @return the correction if the outliers show that the unit has changed
double UnitFilter::doubt(double log_error, double variance) {
  collected_.push_back(log_error);
  if (collected_.size() > kToChange) collected_.pop_front();
  const double piece = params_.correlated * height_;
  if (collected_.size() < kToChange || unseen_ < kPiecesToChange * piece) return 0.0;
  const double bound = params_.gate * std::max(1.0, surprise_) * variance;
  const std::vector<double> latest(collected_.begin(), collected_.end());
  if (square(medianDeviation(latest, median(latest))) <= bound) return finishStart();
  lost_ = doubted_ >= kPiecesToLose * piece;
  return 0.0;
}

/// Takes the median of the collected measurements as a measurement of a unit that hardly is known.
double UnitFilter::finishStart() {
  const std::vector<double> measured(collected_.begin(), collected_.end());
  const double correction = median(measured);
  variance_ = square(medianDeviation(measured, correction)) + square(params_.start_sigma / kToStart);
  collected_.clear();
  starting_ = false;
  unseen_ = doubted_ = block_way_ = block_correction_ = 0.0;
  return correction;
}

double UnitFilter::take(double log_error, double said_variance) {
  const double variance = std::max(1.0, surprise_) * said_variance;  // the road can be rougher than assumed
  const double new_share = std::min(1.0, unseen_ / (params_.correlated * height_));
  const double predicted = predictedVariance();
  const double gain = new_share * predicted / (new_share * predicted + variance);
  variance_ = (1.0 - gain) * predicted;
  unseen_ = 0.0;
  return gain * log_error;
}

}  // namespace ratslam
