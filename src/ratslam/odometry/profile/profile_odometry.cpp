#include "ratslam/odometry/profile/profile_odometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "ratslam/common/state.h"
#include "ratslam/odometry/prediction.h"

namespace ratslam {
namespace {

constexpr int kMaxShift = 40;
constexpr std::uint32_t kStateVersion = 2;

struct Range {
  int begin;
  int end;
};

/// Columns (or rows) [begin, end) of a region. @param extent of the image
Range resolve(const std::string& key, int begin, int end, int extent) {
  const int resolved = end < 0 ? extent : end;
  if (resolved > extent) {
    throwBadValue(key + "_max", end, "the image ends at " + std::to_string(extent) + " px");
  }
  if (begin >= resolved) {
    throwBadValue(key + "_min", begin,
                  "the region must start before its end at " + std::to_string(resolved) + " px");
  }
  return {begin, resolved};
}

/// Mean intensity of each column, in [0, 1]. Grey is the mean of the channels. Shape: columns of the region.
std::vector<double> columnProfile(const cv::Mat& region) {
  cv::Mat sums;
  cv::reduce(region, sums, 0, cv::REDUCE_SUM, CV_64F);
  const double full_scale = region.depth() == CV_16U ? 65535.0 : 255.0;
  const int channels = std::min(region.channels(), 3);  // a fourth channel is alpha
  const double scale = 1.0 / (full_scale * region.rows * channels);
  std::vector<double> profile(static_cast<std::size_t>(region.cols));
  for (int column = 0; column < region.cols; ++column) {
    const double* values = sums.ptr<double>(0) + static_cast<std::ptrdiff_t>(column) * region.channels();
    double sum = 0.0;
    for (int channel = 0; channel < channels; ++channel) sum += values[channel];
    profile[static_cast<std::size_t>(column)] = sum * scale;
  }
  return profile;
}

struct BestShift {
  double shift = 0.0;       ///< columns that the scene has moved to the right
  double difference = 0.0;  ///< mean absolute difference there
};

/// Mean absolute difference of `now` and `before` moved to the right by `shift` columns.
double differenceAt(const std::vector<double>& before, const std::vector<double>& now, int shift) {
  const int columns = static_cast<int>(now.size());
  const int overlap = columns - std::abs(shift);
  const double* a = before.data() + std::max(0, -shift);
  const double* b = now.data() + std::max(0, shift);
  double sum = 0.0;
  for (int i = 0; i < overlap; ++i) sum += std::abs(a[i] - b[i]);
  return sum / overlap;
}

BestShift compareProfiles(const std::vector<double>& before, const std::vector<double>& now, bool subpixel) {
  const int limit = std::min(kMaxShift, static_cast<int>(now.size()) / 2);
  std::vector<double> differences;
  for (int shift = -limit; shift <= limit; ++shift) differences.push_back(differenceAt(before, now, shift));
  // Of equal differences the smallest turn wins, so that a blank wall is no rotation.
  std::size_t best = static_cast<std::size_t>(limit);
  for (int distance = 1; distance <= limit; ++distance) {
    for (const int shift : {-distance, distance}) {
      const auto index = static_cast<std::size_t>(shift + limit);
      if (differences[index] < differences[best]) best = index;
    }
  }
  BestShift result{static_cast<double>(best) - limit, differences[best]};
  if (subpixel && best > 0 && best + 1 < differences.size()) {
    const double curvature = differences[best - 1] - 2.0 * differences[best] + differences[best + 1];
    if (curvature > 0.0) result.shift += 0.5 * (differences[best - 1] - differences[best + 1]) / curvature;
  }
  return result;
}

/// Relative error of the speed: vtrans_scaling suits a scene to about a quarter.
constexpr double kSpeedError = 0.25;
constexpr double kSmallestSpeedError = 0.1;  // [m/s]
/// Variance along the axes that a planar odometry assumes to be zero.
constexpr double kAssumedVariance = 1e-6;

}  // namespace

void ProfileOdometryParams::validate() const { checkBounds(*this); }

ProfileOdometry::ProfileOdometry(const ProfileOdometryParams& params) : params_(params) {
  params_.validate();
}

void ProfileOdometry::save(State& state) const {
  state.setVersion(kStateVersion);
  state.set("previous", previous_);
  state.set("bridged_to", bridged_to_);
  state.set("bridged_from", bridged_from_);
  state.set("speed", speed_);
  state.set("pose", std::array<double, 3>{pose_.x, pose_.y, pose_.th});
}

void ProfileOdometry::load(const State& state) {
  state.requireVersion(kStateVersion);
  state.get("previous", previous_);
  state.get("bridged_to", bridged_to_);
  state.get("bridged_from", bridged_from_);
  state.get("speed", speed_);
  const auto pose = state.get<std::array<double, 3>>("pose");
  pose_ = {pose[0], pose[1], pose[2]};
}

OdometrySample ProfileOdometry::track(Stamp stamp, const cv::Mat& image) {
  if (image.empty() || (image.depth() != CV_8U && image.depth() != CV_16U)) {
    throw std::invalid_argument(
        "image: empty or neither 8 nor 16 bits deep; the odometry takes grey or colour images");
  }
  if (previous_ && previous_->size != image.size()) {
    throw std::invalid_argument("image: size changed from " + std::to_string(previous_->size.width) + "x" +
                                std::to_string(previous_->size.height) + " to " + std::to_string(image.cols) +
                                "x" + std::to_string(image.rows));
  }
  const auto profileOf = [&image](const std::string& key, int x_min, int x_max, int y_min, int y_max) {
    const Range x = resolve(key + "_x", x_min, x_max, image.cols);
    const Range y = resolve(key + "_y", y_min, y_max, image.rows);
    return columnProfile(image(cv::Range(y.begin, y.end), cv::Range(x.begin, x.end)));
  };
  View view{
      stamp, image.size(),
      profileOf("vrot_image", params_.vrot_x_min, params_.vrot_x_max, params_.vrot_y_min, params_.vrot_y_max),
      profileOf("vtrans_image", params_.vtrans_x_min, params_.vtrans_x_max, params_.vtrans_y_min,
                params_.vtrans_y_max)};

  OdometrySample sample;
  sample.stamp = stamp;
  double dt = 0.0;
  if (bridged_to_) {
    sample = bridge(stamp);
    bridged_to_.reset();
    bridged_from_.reset();
    previous_ = std::move(view);
    return sample;
  }
  if (previous_) {
    dt = secondsSince(previous_->stamp, stamp);
    const BestShift turn = compareProfiles(previous_->rotation, view.rotation, params_.subpixel);
    const BestShift change = compareProfiles(previous_->translation, view.translation, false);
    sample.yaw_rate = turn.shift * degreesToRadians(params_.fov_deg) / image.cols / dt;
    sample.speed = std::min(change.difference * params_.vtrans_scaling, params_.vtrans_max);
    sample.covariance = covariance(sample.speed, image.cols, dt);
  }
  finish(sample, dt);
  previous_ = std::move(view);
  return sample;
}

OdometrySample ProfileOdometry::bridge(Stamp stamp) {
  OdometrySample sample;
  sample.stamp = stamp;
  sample.bridged = true;
  const std::optional<Stamp> before =
      bridged_to_ ? bridged_to_ : (previous_ ? std::optional<Stamp>(previous_->stamp) : std::nullopt);
  if (!bridged_from_) bridged_from_ = before;
  if (before && secondsBetween(*bridged_from_, stamp) <= kLongestPrediction_s) sample.speed = speed_;
  finish(sample, before ? secondsSince(*before, stamp) : 0.0);
  previous_.reset();
  bridged_to_ = stamp;
  return sample;
}

void ProfileOdometry::restart() {
  previous_.reset();
  bridged_to_.reset();
  bridged_from_.reset();
  speed_ = 0.0;
}

TwistCovariance ProfileOdometry::covariance(double speed, int image_columns, double dt) const {
  const double speed_error = std::max(kSmallestSpeedError, kSpeedError * speed);
  const double yaw_rate_error = degreesToRadians(params_.fov_deg) / image_columns / dt;  // one pixel
  TwistCovariance covariance = TwistCovariance::Identity() * kAssumedVariance;
  covariance(0, 0) = speed_error * speed_error;
  covariance(5, 5) = yaw_rate_error * yaw_rate_error;
  return covariance;
}

double ProfileOdometry::secondsSince(Stamp before, Stamp now) const {
  const double measured = secondsBetween(before, now);
  return measured > 0.0 ? measured : 1.0 / params_.camera_hz;
}

void ProfileOdometry::finish(OdometrySample& sample, double dt) {
  pose_.th = wrapAngle(pose_.th + sample.yaw_rate * dt);
  pose_.x += sample.speed * dt * std::cos(pose_.th);
  pose_.y += sample.speed * dt * std::sin(pose_.th);
  sample.pose =
      Eigen::Translation3d(pose_.x, pose_.y, 0.0) * Eigen::AngleAxisd(pose_.th, Eigen::Vector3d::UnitZ());
  speed_ = sample.speed;
}

}  // namespace ratslam
