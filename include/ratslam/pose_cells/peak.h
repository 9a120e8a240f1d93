/// Best estimate of the pose cells.
///
///  1. Find the most active cell; of equals the first in the order heading, row, column.
///  2. In the window of +-3 cells around it, take the circular mean (population vector) of each of the three
///     marginal sums.
#pragma once

#include <vector>

#include "ratslam/pose_cells/activity_grid.h"
#include "ratslam/simd/row_kernels.h"

namespace ratslam {

class PeakDecoder {
 public:
  PeakDecoder(int n_xy, int n_th, SimdLevel level);
  /// If a ring is shorter than the window, each of its cells counts once.
  PoseCellEstimate decode(const ActivityGrid& grid) const;

 private:
  struct Direction {
    double cosine = 1.0;
    double sine = 0.0;
  };
  static std::vector<Direction> directions(int size);
  PoseCell mostActive(const ActivityGrid& grid) const;

  std::vector<Direction> directions_xy_;  ///< of the cells along x or y, taken as a circle
  std::vector<Direction> directions_th_;
  const RowKernels* kernels_;
};

}  // namespace ratslam
