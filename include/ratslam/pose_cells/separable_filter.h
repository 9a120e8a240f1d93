/// Convolution of a box of cells with a separable, symmetric kernel: columns, then rows, then layers.
///
/// 1. Gather a layer's rows, with as many cells around them as the kernel reaches (wrapped on a ring, else 0).
/// 2. Convolve them along columns and along rows.
/// 3. As soon as all layers that an output layer needs are done, convolve them along the layers. Only the layers
///    that are still needed are kept, so that all work happens in the cache.
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

/// Weights at offsets 0, 1, ..., dim / 2 of a truncated Gaussian that sums to 1. @param dim odd side. @param width
/// standard deviation [cells].
std::vector<double> halfGaussian(int dim, double width);

/// View of layers of rows in memory that it does not own.
struct CellSource {
  const double* cells = nullptr;
  std::ptrdiff_t layer_stride = 0;
  std::ptrdiff_t row_stride = 0;
};

/// A box of cells in memory, layer by layer, row by row.
struct Volume {
  std::array<int, 3> counts{};  ///< columns, rows, layers
  int width = 0;                ///< length of a row in memory: columns and padding
  AlignedBuffer<double> cells;

  std::ptrdiff_t layerStride() const { return static_cast<std::ptrdiff_t>(width) * counts[kRow]; }
  /// Layer `k`; if there is only one, all k share it.
  double* layer(int k) { return cells.data() + (counts[kLayer] > 1 ? k * layerStride() : 0); }
  CellSource source() const { return {cells.data(), layerStride(), width}; }
  void resize(const std::array<int, 3>& new_counts);
};

class SeparableFilter {
 public:
  /// @param dim odd side of the kernel; @param width_xy, width_th standard deviations [cells], [layers].
  SeparableFilter(int dim, double width_xy, double width_th, const RowKernels& kernels);

  int radius() const { return radius_; }

  /// @param axes along columns, rows, layers. @param out has their counts of columns and rows, and as many layers
  /// or one that is used for all in turn. Its padding gets finite non-negative values if those of `in` are.
  /// @param done is called with the number of each finished layer.
  void apply(const CellSource& in, const std::array<GatherAxis, 3>& axes, Volume& out,
             const std::function<void(int)>& done);

 private:
  void reserve(const std::array<GatherAxis, 3>& axes, const Volume& out);
  /// Memory for the layer at a position, filtered within the plane.
  double* keptLayer(const GatherAxis& layers, int position, std::ptrdiff_t layer_size);
  void filterPlane(const double* layer, const GatherAxis& rows, int width, double* out);

  int radius_;
  std::vector<double> weights_xy_;
  std::vector<double> weights_th_;
  const RowKernels* kernels_;
  RowPlan gathering_;
  std::ptrdiff_t gathered_stride_ = 0;   ///< between gathered rows
  AlignedBuffer<double> gathered_;       ///< one layer's rows with the cells around them
  AlignedBuffer<double> along_columns_;  ///< one layer, filtered along columns
  AlignedBuffer<double> kept_;           ///< layers filtered within the plane
  std::vector<const double*> taps_;      ///< the layer that each tap of the kernel reads
};

}  // namespace ratslam
