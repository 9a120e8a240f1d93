#include "ratslam/pose_cells/peak.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ratslam/common/angles.h"

namespace ratslam {
namespace {

constexpr int kReach = 3;
constexpr int kWindow = 2 * kReach + 1;
using Marginal = std::array<double, kWindow>;

}  // namespace

std::vector<PeakDecoder::Direction> PeakDecoder::directions(int size) {
  std::vector<Direction> table;
  for (int i = 0; i < size; ++i) {
    const double angle = i * 2.0 * kPi / size;
    table.push_back({std::cos(angle), std::sin(angle)});
  }
  return table;
}

PeakDecoder::PeakDecoder(int n_xy, int n_th, SimdLevel level)
    : directions_xy_(directions(n_xy)), directions_th_(directions(n_th)), kernels_(&rowKernels(level)) {}

PoseCell PeakDecoder::mostActive(const ActivityGrid& grid) const {
  double largest = 0.0;
  std::size_t run = 0;
  grid.forEachRun([&](std::size_t first, std::size_t count) {
    const double here = kernels_->maximum(grid.data() + first, static_cast<std::ptrdiff_t>(count));
    if (here > largest || (here == largest && first < run)) {
      largest = here;
      run = first;
    }
  });
  while (grid.data()[run] != largest) ++run;
  const std::size_t columns = static_cast<std::size_t>(grid.nXy());
  return {static_cast<int>(run % columns), static_cast<int>(run / columns % columns),
          static_cast<int>(run / (columns * columns))};
}

PoseCellEstimate PeakDecoder::decode(const ActivityGrid& grid) const {
  const PoseCell best = mostActive(grid);
  Marginal along_x{};
  Marginal along_y{};
  Marginal along_th{};
  const int width_xy = std::min(kWindow, grid.nXy());
  const int width_th = std::min(kWindow, grid.nTh());
  for (int c = 0; c < width_th; ++c)
    for (int b = 0; b < width_xy; ++b)
      for (int a = 0; a < width_xy; ++a) {
        const double activity = grid.at({wrapIndex(best.column - kReach + a, grid.nXy()),
                                         wrapIndex(best.row - kReach + b, grid.nXy()),
                                         wrapIndex(best.layer - kReach + c, grid.nTh())});
        along_x[static_cast<std::size_t>(a)] += activity;
        along_y[static_cast<std::size_t>(b)] += activity;
        along_th[static_cast<std::size_t>(c)] += activity;
      }

  const auto circularMean = [](const Marginal& marginal, int width, int centre,
                               const std::vector<Direction>& ring) {
    const int size = static_cast<int>(ring.size());
    Direction sum{0.0, 0.0};
    for (int a = 0; a < width; ++a) {
      const Direction& direction = ring[static_cast<std::size_t>(wrapIndex(centre - kReach + a, size))];
      sum.cosine += marginal[static_cast<std::size_t>(a)] * direction.cosine;
      sum.sine += marginal[static_cast<std::size_t>(a)] * direction.sine;
    }
    return wrapCoordinate(std::atan2(sum.sine, sum.cosine) * size / (2.0 * kPi), size);
  };
  return {circularMean(along_x, width_xy, best.column, directions_xy_),
          circularMean(along_y, width_xy, best.row, directions_xy_),
          circularMean(along_th, width_th, best.layer, directions_th_)};
}

}  // namespace ratslam
