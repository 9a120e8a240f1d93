/// Consensus of minimal samples (Fischler and Bolles 1981) with truncated costs (MSAC: Torr and Zisserman 2000).
///
/// The random generator is seeded in each call, and the C++ standard defines its sequence: the same data give the same
/// model, with every compiler and on every processor.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>

namespace ratslam {

struct ConsensusParams {
  double confidence = 0.99;  ///< probability that one sample was free of outliers
  int least = 50;            ///< samples: the first clean one may lead to the wrong one of two similar minima
  int most = 150;
};

/// How well a model fits. Less `cost` is better.
struct ConsensusScore {
  static constexpr double kGate = 4.0;  ///< largest error of an inlier [sigma]

  double cost = std::numeric_limits<double>::infinity();
  int inliers = 0;

  /// @param squared_error in units of sigma^2
  void add(double squared_error) {
    cost += std::min(squared_error, kGate * kGate);
    if (squared_error < kGate * kGate) ++inliers;
  }
};

/// Draws samples of `kSize` different items until one of them is free of outliers with `params.confidence`.
/// @param count of items, at least kSize
/// @param consider called with the indices of a sample; returns the inliers of the best model so far
template <std::size_t kSize, class Consider>
void drawSamples(std::size_t count, const ConsensusParams& params, Consider&& consider) {
  std::mt19937 generator;
  int needed = params.most;
  for (int drawn = 0; drawn < needed; ++drawn) {
    std::array<std::size_t, kSize> sample;
    for (std::size_t k = 0; k < kSize;) {
      sample[k] = generator() % count;
      if (std::find(sample.begin(), sample.begin() + static_cast<std::ptrdiff_t>(k), sample[k]) ==
          sample.begin() + static_cast<std::ptrdiff_t>(k)) {
        ++k;
      }
    }
    const double share = static_cast<double>(consider(sample)) / static_cast<double>(count);
    const double clean = std::pow(share, static_cast<double>(kSize));
    // log1p(-1) is minus infinity, which gives the least number; log1p(0) is 0, which gives the most.
    const double enough = std::log(1.0 - params.confidence) / std::log1p(-clean);
    needed = static_cast<int>(std::clamp(std::abs(enough), 1.0 * params.least, 1.0 * params.most));
  }
}

}  // namespace ratslam
