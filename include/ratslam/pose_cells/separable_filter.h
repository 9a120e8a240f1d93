/// Convolution of a box of cells with a separable, symmetric kernel: columns, then rows, then layers.
///
/// 1. A layer's rows are gathered with as many cells around them as the kernel reaches (wrapped on a ring,
/// else 0).
/// 2. They are convolved along columns and along rows, while in the cache.
/// 3. The layers are convolved with each other.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "ratslam/pose_cells/aligned_buffer.h"
#include "ratslam/pose_cells/gather.h"
#include "ratslam/pose_cells/region.h"
#include "ratslam/pose_cells/simd.h"

namespace ratslam {

/// Truncated Gaussian of odd side `dim` that sums to 1: its weights at offsets 0, 1, ..., dim / 2.
std::vector<double> halfGaussian(int dim, double width);

/// A box of cells in memory; rows padded to `width`.
struct Volume {
  std::array<int, 3> counts{};  ///< columns, rows, layers
  int width = 0;
  AlignedBuffer<double> cells;

  std::ptrdiff_t rowStride() const { return width; }
  std::ptrdiff_t layerStride() const { return static_cast<std::ptrdiff_t>(width) * counts[kRow]; }
  std::ptrdiff_t size() const { return layerStride() * counts[kLayer]; }
  void resize(const std::array<int, 3>& new_counts);
  VolumeView<double> view() { return {cells.data(), layerStride(), rowStride()}; }
  VolumeView<const double> view() const { return {cells.data(), layerStride(), rowStride()}; }
};

class SeparableFilter {
 public:
  /// @param dim side of the kernel, odd; @param width_xy, width_th of the Gaussian [cells], [layers].
  SeparableFilter(int dim, double width_xy, double width_th, const RowKernels& kernels);

  int radius() const { return radius_; }

  /// @param axes along columns, rows, layers; @param out gets their counts as its own. Its padding columns
  /// hold finite, non-negative values if `in` does.
  void apply(VolumeView<const double> in, const std::array<GatherAxis, 3>& axes, Volume& out);

 private:
  /// Prepares what is the same for all layers: which cells of a row and which rows go where.
  void planGathering(const GatherAxis& columns, const GatherAxis& rows, std::ptrdiff_t row_stride);
  void filterLayer(const double* layer, const GatherAxis& rows, double* out);

  int radius_;
  std::vector<double> weights_xy_;
  std::vector<double> weights_th_;
  const RowKernels* kernels_;
  int width_ = 0;                        ///< of a filtered row
  std::ptrdiff_t gathered_stride_ = 0;   ///< between gathered rows
  AlignedBuffer<double> gathered_;       ///< one layer's rows with what is around them
  AlignedBuffer<double> along_columns_;  ///< one layer, filtered along columns
  AlignedBuffer<double> in_plane_;       ///< all layers, filtered within the plane
  std::vector<RowSegment> segments_;
  std::vector<std::ptrdiff_t> from_, to_;
};

}  // namespace ratslam
