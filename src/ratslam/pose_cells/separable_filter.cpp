#include "ratslam/pose_cells/separable_filter.h"

#include <algorithm>
#include <cmath>

namespace ratslam {

std::vector<double> halfGaussian(int dim, double width) {
  std::vector<double> weights;
  double sum = 0.0;
  for (int a = 0; a <= dim / 2; ++a) {
    weights.push_back(std::exp(-a * a / (2.0 * width * width)));
    sum += a == 0 ? weights.back() : 2.0 * weights.back();
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

void Volume::resize(const std::array<int, 3>& new_counts) {
  counts = new_counts;
  width = paddedWidth(counts[kColumn]);
  cells.atLeast(
      static_cast<std::size_t>(size() + kRowQuantum));  // readers of columns in the middle may look past
}

SeparableFilter::SeparableFilter(int dim, double width_xy, double width_th, const RowKernels& kernels)
    : radius_(dim / 2),
      weights_xy_(halfGaussian(dim, width_xy)),
      weights_th_(halfGaussian(dim, width_th)),
      kernels_(&kernels) {}

void SeparableFilter::planGathering(const GatherAxis& columns, const GatherAxis& rows,
                                    std::ptrdiff_t row_stride) {
  width_ = paddedWidth(columns.count);
  gathered_stride_ = paddedWidth(width_ + 2 * radius_);
  segments_.clear();
  appendSegments(
      segments_, columns.last - columns.first, [&](int c) { return columns.source(columns.first + c); },
      [&](int c) { return columns.first + c; });
  from_.clear();
  to_.clear();
  for (int p = rows.first; p < rows.last; ++p) {
    from_.push_back(rows.source(p) * row_stride);
    to_.push_back(p * gathered_stride_);
  }
  // What has no source stays 0 from here on, whichever layer's rows come.
  const std::size_t positions = rows.sources.size();
  const std::size_t gathered_size = positions * static_cast<std::size_t>(gathered_stride_);
  const std::size_t filtered_size = positions * static_cast<std::size_t>(width_);
  std::fill_n(gathered_.atLeast(gathered_size), gathered_size, 0.0);
  std::fill_n(along_columns_.atLeast(filtered_size), filtered_size, 0.0);
}

void SeparableFilter::apply(VolumeView<const double> in, const std::array<GatherAxis, 3>& axes, Volume& out) {
  const GatherAxis& layers = axes[kLayer];
  out.resize({axes[kColumn].count, axes[kRow].count, layers.count});
  planGathering(axes[kColumn], axes[kRow], in.row_stride);

  const std::ptrdiff_t layer_size = out.layerStride();
  const int positions = static_cast<int>(layers.sources.size());
  double* const in_plane = in_plane_.atLeast(layers.sources.size() * static_cast<std::size_t>(layer_size));
  for (int p = 0; p < positions; ++p) {
    double* const filtered = in_plane + p * layer_size;
    if (p < layers.first || p >= layers.last) {
      std::fill_n(filtered, layer_size, 0.0);
    } else if (layers.period > 0 && p >= layers.period) {
      std::copy_n(filtered - layers.period * layer_size, layer_size, filtered);
    } else {
      filterLayer(in.data + layers.source(p) * in.layer_stride, axes[kRow], filtered);
    }
  }
  kernels_->convolve(in_plane, 0, layer_size, out.cells.data(), 0, 1, out.size(), weights_th_.data(),
                     radius_);
}

void SeparableFilter::filterLayer(const double* layer, const GatherAxis& rows, double* out) {
  const int n_rows = rows.last - rows.first;
  kernels_->copy({layer, from_.data()}, {gathered_.data(), to_.data()}, n_rows, segments_.data(),
                 static_cast<int>(segments_.size()));
  kernels_->convolve(gathered_.data() + rows.first * gathered_stride_, gathered_stride_, 1,
                     along_columns_.data() + static_cast<std::ptrdiff_t>(rows.first) * width_, width_, n_rows,
                     width_, weights_xy_.data(), radius_);
  kernels_->convolve(along_columns_.data(), 0, width_, out, 0, 1,
                     static_cast<std::ptrdiff_t>(width_) * rows.count, weights_xy_.data(), radius_);
}

}  // namespace ratslam
