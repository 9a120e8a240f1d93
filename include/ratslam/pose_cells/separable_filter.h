/// Convolution of a box of cells with a separable, symmetric kernel: columns, then rows, then layers.
///
/// 1. A layer's rows are gathered with as many cells around them as the kernel reaches (wrapped on a ring,
///    else 0).
/// 2. They are convolved along columns and along rows.
/// 3. As soon as all layers that an output layer needs are there, they are convolved with
///    each other; no more of them are kept than are still needed. All of it happens in the
///    cache.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "ratslam/pose_cells/aligned_buffer.h"
#include "ratslam/pose_cells/gather.h"
#include "ratslam/pose_cells/region.h"
#include "ratslam/simd/row_kernels.h"

namespace ratslam {

/// Truncated Gaussian of odd side `dim` that sums to 1: its weights at offsets 0, 1, ..., dim / 2.
std::vector<double> halfGaussian(int dim, double width);

/// Layers of rows, somewhere in memory.
struct CellSource {
  const double* cells = nullptr;
  std::ptrdiff_t layer_stride = 0;
  std::ptrdiff_t row_stride = 0;
};

/// A box of cells in memory, layer by layer, row by row.
struct Volume {
  std::array<int, 3> counts{};  ///< columns, rows, layers
  int width = 0;                ///< of a row in memory: columns, padded
  AlignedBuffer<double> cells;

  std::ptrdiff_t layerStride() const { return static_cast<std::ptrdiff_t>(width) * counts[kRow]; }
  /// Layer `k`, or what all share.
  double* layer(int k) { return cells.data() + (counts[kLayer] > 1 ? k * layerStride() : 0); }
  CellSource source() const { return {cells.data(), layerStride(), width}; }
  void resize(const std::array<int, 3>& new_counts);
};

class SeparableFilter {
 public:
  /// @param dim side of the kernel, odd; @param width_xy, width_th of the Gaussian [cells], [layers].
  SeparableFilter(int dim, double width_xy, double width_th, const RowKernels& kernels);

  int radius() const { return radius_; }

  /// @param axes along columns, rows, layers; @param out of as many columns and rows as they count, and as
  /// many layers or one, which is used for all in turn; its padding columns get values that are finite and
  /// non-negative if those of `in` are; @param done is called with each finished layer.
  void apply(const CellSource& in, const std::array<GatherAxis, 3>& axes, Volume& out,
             const std::function<void(int)>& done);

 private:
  void reserve(const std::array<GatherAxis, 3>& axes, const Volume& out);
  /// Where the layer at a position is kept once it is filtered within the plane.
  double* keptLayer(const GatherAxis& layers, int position, std::ptrdiff_t layer_size);
  void filterPlane(const double* layer, const GatherAxis& rows, int width, double* out);

  int radius_;
  std::vector<double> weights_xy_;
  std::vector<double> weights_th_;
  const RowKernels* kernels_;
  RowPlan gathering_;
  std::ptrdiff_t gathered_stride_ = 0;   ///< between gathered rows
  AlignedBuffer<double> gathered_;       ///< one layer's rows with what is around them
  AlignedBuffer<double> along_columns_;  ///< one layer, filtered along columns
  AlignedBuffer<double> kept_;           ///< layers filtered within the plane
  std::vector<const double*> taps_;      ///< what a kernel's taps read
};

}  // namespace ratslam
