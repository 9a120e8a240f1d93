#include "town/road_field.h"

#include <algorithm>
#include <cmath>

#include "ratslam/common/params.h"

namespace ratslam {
namespace {

constexpr double kBucket = 8.0;    // [m]
constexpr double kLattice = 4.0;   // [m]
constexpr double kRounding = 5.0;  // [m] reach over which heights blend along and across a road

/// Distance from x to the interval [low, low + kBucket].
double outside(double x, double low) { return std::max({low - x, x - low - kBucket, 0.0}); }

}  // namespace

RoadField::RoadField(const std::vector<std::vector<RoadPoint>>& roads) {
  if (roads.empty()) throwBadValue("roads", 0, "a town needs at least one road");
  for (const auto& road : roads) addAxis(road);
  const RoadAxis::Sample& first = axes_.front().samples.front();
  x_min_ = x_max_ = first.x;
  z_min_ = z_max_ = first.z;
  for (const RoadAxis& axis : axes_)
    for (const RoadAxis::Sample& sample : axis.samples) {
      x_min_ = std::min(x_min_, sample.x);
      x_max_ = std::max(x_max_, sample.x);
      z_min_ = std::min(z_min_, sample.z);
      z_max_ = std::max(z_max_, sample.z);
    }
  bucket_columns_ = static_cast<int>((x_max_ - x_min_) / kBucket) + 1;
  bucket_rows_ = static_cast<int>((z_max_ - z_min_) / kBucket) + 1;
  buckets_.resize(static_cast<std::size_t>(bucket_columns_) * static_cast<std::size_t>(bucket_rows_));
  for (std::size_t a = 0; a < axes_.size(); ++a)
    for (std::size_t i = 0; i < axes_[a].samples.size(); ++i) {
      const RoadAxis::Sample& sample = axes_[a].samples[i];
      const auto column = static_cast<std::size_t>((sample.x - x_min_) / kBucket);
      const auto row = static_cast<std::size_t>((sample.z - z_min_) / kBucket);
      buckets_[row * static_cast<std::size_t>(bucket_columns_) + column].push_back(
          {static_cast<float>(sample.x), static_cast<float>(sample.z), static_cast<std::uint32_t>(a),
           static_cast<std::uint32_t>(i)});
    }
  findFirstVisits();
  tabulateHeights();
}

template <class Visit>
void RoadField::visitBuckets(double x, double z, const double& reach, Visit&& visit) const {
  // Own bucket first, then rings round it: `reach` may shrink while the visit goes on.
  const int column = static_cast<int>(std::floor((x - x_min_) / kBucket));
  const int row = static_cast<int>(std::floor((z - z_min_) / kBucket));
  for (int ring = 0; (ring - 1) * kBucket < reach; ++ring)
    for (int r = row - ring; r <= row + ring; ++r) {
      const bool whole_row = std::abs(r - row) == ring;
      for (int c = column - ring; c <= column + ring; c += whole_row ? 1 : 2 * ring) {
        if (r < 0 || r >= bucket_rows_ || c < 0 || c >= bucket_columns_) continue;
        const double dx = outside(x, x_min_ + c * kBucket);
        const double dz = outside(z, z_min_ + r * kBucket);
        if (dx * dx + dz * dz >= reach * reach) continue;
        visit(buckets_[static_cast<std::size_t>(r) * static_cast<std::size_t>(bucket_columns_) +
                       static_cast<std::size_t>(c)]);
      }
    }
}

void RoadField::addAxis(const std::vector<RoadPoint>& points) {
  RoadAxis axis;
  double to_next = 0.0;  // from the present point to the next sample
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const RoadPoint& a = points[i];
    const RoadPoint& b = points[i + 1];
    const double length = std::hypot(b.x - a.x, b.z - a.z);
    if (!std::isfinite(length) || !std::isfinite(a.height) || !std::isfinite(b.height))
      throwBadValue("road point", i, "its coordinates must be finite");
    for (; length > 0.0 && to_next <= length; to_next += RoadAxis::kStep) {
      const double t = to_next / length;
      axis.samples.push_back({a.x + t * (b.x - a.x), a.z + t * (b.z - a.z),
                              a.height + t * (b.height - a.height), 0.0, 0.0, true});
    }
    to_next -= length;
  }
  const std::size_t count = axis.samples.size();
  if (count < 2) throwBadValue("road length", points.size(), "a road must be longer than one metre");
  // A tangent over 2 m does not jitter with the points a drive was recorded at.
  constexpr std::size_t kHalf = 2;
  for (std::size_t i = 0; i < count; ++i) {
    const auto& a = axis.samples[i >= kHalf ? i - kHalf : 0];
    const auto& b = axis.samples[std::min(i + kHalf, count - 1)];
    const double length = std::hypot(b.x - a.x, b.z - a.z);
    axis.samples[i].forward_x = length > 0.0 ? (b.x - a.x) / length : 0.0;
    axis.samples[i].forward_z = length > 0.0 ? (b.z - a.z) / length : 1.0;
  }
  axes_.push_back(std::move(axis));
}

void RoadField::findFirstVisits() {
  constexpr double kSame = 5.0;                                                 // [m]
  constexpr auto kRecent = static_cast<std::uint32_t>(40.0 / RoadAxis::kStep);  // samples
  for (std::uint32_t a = 0; a < axes_.size(); ++a)
    for (std::uint32_t i = 0; i < axes_[a].samples.size(); ++i) {
      RoadAxis::Sample& sample = axes_[a].samples[i];
      visitBuckets(sample.x, sample.z, kSame, [&](const Bucket& bucket) {
        for (const Place& place : bucket) {
          const bool earlier = place.axis < a || (place.axis == a && place.sample + kRecent < i);
          if (earlier && std::hypot(place.x - sample.x, place.z - sample.z) < kSame)
            sample.first_visit = false;
        }
      });
    }
}

double RoadField::distance(double x, double z) const {
  double nearest = kFar;
  visitBuckets(x, z, nearest, [&](const Bucket& bucket) {
    double square = nearest * nearest;
    for (const Place& place : bucket) {
      const double dx = place.x - x;
      const double dz = place.z - z;
      square = std::min(square, dx * dx + dz * dz);
    }
    nearest = std::sqrt(square);
  });
  return nearest;
}

void RoadField::tabulateHeights() {
  columns_ = static_cast<std::size_t>((x_max_ - x_min_ + 2.0 * kMargin) / kLattice) + 2;
  rows_ = static_cast<std::size_t>((z_max_ - z_min_ + 2.0 * kMargin) / kLattice) + 2;
  heights_.assign(columns_ * rows_, 0.0F);
  std::vector<RoadPoint> sparse;
  bool flat = true;
  for (const RoadAxis& axis : axes_)
    for (std::size_t i = 0; i < axis.samples.size(); i += 5) {
      sparse.push_back({axis.samples[i].x, axis.samples[i].z, axis.samples[i].height});
      flat = flat && sparse.back().height == sparse.front().height;
    }
  if (flat) {
    std::fill(heights_.begin(), heights_.end(), static_cast<float>(sparse.front().height));
    return;
  }
  for (std::size_t row = 0; row < rows_; ++row)
    for (std::size_t column = 0; column < columns_; ++column) {
      const double x = x_min_ - kMargin + kLattice * static_cast<double>(column);
      const double z = z_min_ - kMargin + kLattice * static_cast<double>(row);
      double weights = 0.0;
      double sum = 0.0;
      for (const RoadPoint& point : sparse) {
        const double square_distance = (point.x - x) * (point.x - x) + (point.z - z) * (point.z - z);
        const double r = 1.0 / (square_distance + kRounding * kRounding);
        const double weight = r * r * r;
        weights += weight;
        sum += weight * point.height;
      }
      heights_[row * columns_ + column] = static_cast<float>(sum / weights);
    }
}

double RoadField::height(double x, double z) const {
  const double column =
      std::clamp((x - x_min_ + kMargin) / kLattice, 0.0, static_cast<double>(columns_) - 1.001);
  const double row = std::clamp((z - z_min_ + kMargin) / kLattice, 0.0, static_cast<double>(rows_) - 1.001);
  const auto c = static_cast<std::size_t>(column);
  const auto r = static_cast<std::size_t>(row);
  const double fc = column - static_cast<double>(c);
  const double fr = row - static_cast<double>(r);
  const float* const near = &heights_[r * columns_ + c];
  const float* const far = near + columns_;
  return (1.0 - fr) * ((1.0 - fc) * near[0] + fc * near[1]) + fr * ((1.0 - fc) * far[0] + fc * far[1]);
}

}  // namespace ratslam
