/// Attractor dynamics of the pose cells, eqs. (1) and (2): one iteration of
///  1. local excitation   P <- P (*) E
///  2. local inhibition   P <- P - P (*) I
///  3. global inhibition  P <- max(0, P - phi)
///  4. normalisation      P <- P / sum(P), left to the caller
/// (*) is circular convolution. E and I are truncated Gaussians that sum to 1.
///
/// Both kernels are separable. Each packet of activity is processed on its own, as a box. Global inhibition
/// makes that exact: a cell whose excitation does not exceed phi ends at 0. So inhibition is computed only for
/// a small core of the excited box, and the packet's box shrinks to that core again.
#pragma once

#include <cstdint>
#include <vector>

#include "ratslam/pose_cells/activity_grid.h"
#include "ratslam/pose_cells/aligned_buffer.h"
#include "ratslam/pose_cells/params.h"
#include "ratslam/pose_cells/separable_filter.h"
#include "ratslam/simd/row_kernels.h"

namespace ratslam {

class Attractor {
 public:
  Attractor(const PoseCellParams& params, SimdLevel level);

  /// Steps 1 to 3. @param grid activity that sums to 1. @param model_sum the sum that the model's activity would
  /// have at this point. @return the sum of the remaining activity; 0: the grid is empty.
  double iterate(ActivityGrid& grid, double model_sum);

 private:
  /// One axis of a packet's box.
  struct Extent {
    bool ring = false;  ///< the excited packet would overlap itself, so the whole ring is processed
    int origin = 0;     ///< cell of the network where the excited box begins
    int count = 0;      ///< cells of the excited box
    Span core;          ///< cells of the excited box where activity may survive
  };

  /// Largest values along each axis of a volume.
  class AxisMaxima {
   public:
    /// Sets all maxima to 0. @param axes along columns, rows, layers.
    void reset(const std::array<GatherAxis, 3>& axes);
    Maxima forLayers() { return {columns_.data(), row_lanes_.data()}; }
    void setLayer(int k, double largest) { layers_[static_cast<std::size_t>(k)] = largest; }
    /// To be called after the last layer: reduces the lanes of each row to one value.
    void finish();
    const double* along(std::size_t axis) const;

   private:
    std::vector<double> columns_, row_lanes_, rows_, layers_;
  };

  void excite(const ActivityGrid& grid, const Box& packet);
  /// Narrows the core to the cells that may survive global inhibition. @return false if there are none.
  bool findCore(double phi);
  /// Whether the core holds all cells of the excited packet.
  bool coreCovers(const Box& packet) const;
  /// Steps 2 and 3 within the core. Writes the result to the grid.
  void inhibit(double phi, double* sums, ActivityGrid& grid);
  void planStoring(const ActivityGrid& grid);
  /// The boxes of the grid that hold the core's activity: several if wide gaps divide it.
  std::vector<Box> occupiedBoxes(const ActivityGrid& grid) const;
  static bool tighten(const ActivityGrid& grid, Box& box);
  /// Grid coordinate of cell `c` of the core along an axis.
  int inGrid(const ActivityGrid& grid, std::size_t axis, int c) const;

  double global_inhibition_;
  const RowKernels* kernels_;
  SeparableFilter excitation_;
  SeparableFilter inhibition_;
  int reach_;  ///< packets with fewer free cells between them are processed together

  std::array<Extent, 3> extents_;
  std::array<GatherAxis, 3> axes_;
  Volume excited_;  ///< the packet after step 1
  Volume core_;     ///< one layer of its core: first the inhibition, then the result
  AxisMaxima maxima_;
  AlignedBuffer<long long> keep_;
  RowPlan storing_;
};

}  // namespace ratslam
