/// Comparison of the fast network with the plain one.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "oracle/pose_cells_oracle.h"
#include "ratslam/pose_cells/network.h"

namespace ratslam {

/// Parameters of a volume of n_th layers of n_xy x n_xy cells.
inline PoseCellParams sized(int n_xy, int n_th) {
  PoseCellParams params;
  params.n_xy = n_xy;
  params.n_th = n_th;
  return params;
}

/// Largest difference of a cell's activity, after both are scaled to sum 1: between an injection and the next
/// iteration the plain network, as the model, is not normalised.
inline double largestDifference(const ActivityGrid& fast, const oracle::Network& plain) {
  double sum = 0.0;
  for (const double cell : plain.cells()) sum += cell;
  double largest = 0.0;
  for (std::size_t c = 0; c < plain.cells().size(); ++c)
    largest = std::max(largest, std::abs(fast.data()[c] - plain.cells()[c] / sum));
  return largest;
}

inline double ringDistance(double a, double b, int size) { return std::abs(std::remainder(a - b, size)); }

inline double largestDifference(const PoseCellEstimate& fast, const oracle::Estimate& plain,
                                const PoseCellParams& params) {
  return std::max({ringDistance(fast.x, plain.x, params.n_xy), ringDistance(fast.y, plain.y, params.n_xy),
                   ringDistance(fast.th, plain.th, params.n_th)});
}

/// The invariants of the activity, and that its boxes hold all of it.
inline void expectSound(const PoseCellNetwork& network) {
  const ActivityGrid& grid = network.activity();
  double sum = 0.0;
  for (std::size_t c = 0; c < grid.offset(grid.nTh(), 0); ++c) {
    ASSERT_GE(grid.data()[c], 0.0);
    sum += grid.data()[c];
  }
  EXPECT_NEAR(sum, 1.0, 1e-12);
  EXPECT_NEAR(grid.sum(), sum, 1e-12);
  const PoseCellEstimate& estimate = network.estimate();
  EXPECT_TRUE(estimate.x >= 0.0 && estimate.x < grid.nXy()) << estimate.x;
  EXPECT_TRUE(estimate.y >= 0.0 && estimate.y < grid.nXy()) << estimate.y;
  EXPECT_TRUE(estimate.th >= 0.0 && estimate.th < grid.nTh()) << estimate.th;
}

}  // namespace ratslam
