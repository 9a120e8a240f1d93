#include "ratslam/local_view/orientation/adaptation.h"

#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

constexpr double kFewest = 50.0;  // time constant at first [views]
constexpr double kMost = 300.0;   // time constant in the end [views]
constexpr double kLeastVariance = 1e-3;

}  // namespace

Adaptation::Adaptation(std::size_t values, std::size_t bins, Sharing sharing)
    : bins_(bins), sharing_(sharing), mean_(values, 0.0), variance_(values, 1.0) {}

std::vector<double> Adaptation::apply(const std::vector<double>& values) const {
  std::vector<double> adapted(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    adapted[i] = (values[i] - mean_[i]) / std::sqrt(variance_[i]);
  }
  return adapted;
}

void Adaptation::start(const std::vector<double>& values) {
  const std::size_t cells = values.size() / bins_;
  std::vector<double> mean(bins_, 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) mean[i % bins_] += values[i] / static_cast<double>(cells);
  double variance = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double from_mean = values[i] - mean[i % bins_];
    variance += from_mean * from_mean / static_cast<double>(values.size());
  }
  for (std::size_t i = 0; i < values.size(); ++i) mean_[i] = mean[i % bins_];
  std::fill(variance_.begin(), variance_.end(), std::max(variance, kLeastVariance));
}

void Adaptation::learn(const std::vector<double>& values) {
  const double seen = static_cast<double>(views_ + 1);
  const double alpha = 1.0 / std::max(kFewest, std::min(seen, kMost));
  const auto group = [&](std::size_t first, auto&& each) {
    for (std::size_t i = 0; i < sharing_.count; ++i) each(first + i * sharing_.stride);
  };
  const std::size_t block = sharing_.stride * sharing_.count;  // size of a block of values that share
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (sharing_.count > 1 && i % block >= sharing_.stride) continue;
    double difference = 0.0;
    double squares = 0.0;
    group(i, [&](std::size_t at) {
      const double d = values[at] - mean_[at];
      difference += d;
      squares += d * d;
    });
    difference /= static_cast<double>(sharing_.count);
    squares /= static_cast<double>(sharing_.count);
    group(i, [&](std::size_t at) {
      mean_[at] += alpha * difference;
      variance_[at] = std::max((1.0 - alpha) * (variance_[at] + alpha * squares), kLeastVariance);
    });
  }
  ++views_;
}

}  // namespace ratslam
