/// Robust statistics.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace ratslam {

inline double square(double value) { return value * value; }

/// The middle value; of an even number, the larger of the two. @param values at least one
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Median of the distances from a value. @param values at least one
inline double medianDeviation(std::vector<double> values, double from) {
  for (double& value : values) value = std::abs(value - from);
  return median(std::move(values));
}

}  // namespace ratslam
