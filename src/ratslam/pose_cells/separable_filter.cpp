#include "ratslam/pose_cells/separable_filter.h"

#include <algorithm>
#include <cmath>

namespace ratslam {

namespace {

constexpr int kRowsAtOnce = 8;  // rows gathered and filtered while the first-level cache holds them

}  // namespace

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
  // A read of padded rows from a column in the middle passes the end by less than a row quantum.
  cells.atLeast(static_cast<std::size_t>(layerStride() * counts[kLayer] + kRowQuantum));
}

SeparableFilter::SeparableFilter(int dim, double width_xy, double width_th, const RowKernels& kernels)
    : radius_(dim / 2),
      weights_xy_(halfGaussian(dim, width_xy)),
      weights_th_(halfGaussian(dim, width_th)),
      kernels_(&kernels),
      taps_(static_cast<std::size_t>(dim)) {}

void SeparableFilter::apply(const CellSource& in, const std::array<GatherAxis, 3>& axes, Volume& out,
                            const std::function<void(int)>& done) {
  const GatherAxis& layers = axes[kLayer];
  gathered_stride_ = paddedWidth(out.width + 2 * radius_);
  gathering_.planGathering(axes[kColumn], axes[kRow], in.row_stride, gathered_stride_);
  reserve(axes, out);

  const std::ptrdiff_t layer_size = out.layerStride();
  int filtered = layers.first;
  for (int k = 0; k < layers.count; ++k) {
    for (; filtered <= k + 2 * radius_ && filtered < layers.last; ++filtered) {
      const bool known = layers.period > 0 && filtered >= layers.period;  // on a ring the first layers repeat
      if (!known)
        filterPlane(in.cells + layers.source(filtered) * in.layer_stride, axes[kRow], out.width,
                    keptLayer(layers, filtered, layer_size));
    }
    for (std::size_t t = 0; t < taps_.size(); ++t)
      taps_[t] = keptLayer(layers, k + static_cast<int>(t), layer_size);
    kernels_->convolve(taps_.data(), 0, out.layer(k), 0, 1, layer_size, weights_th_.data(), radius_);
    done(k);
  }
}

/// Allocates memory and zeroes the cells without a source: these stay 0 for the rows of all layers.
void SeparableFilter::reserve(const std::array<GatherAxis, 3>& axes, const Volume& out) {
  const auto positions_y = static_cast<std::size_t>(axes[kRow].positions());
  const std::size_t gathered_size = positions_y * static_cast<std::size_t>(gathered_stride_);
  std::fill_n(gathered_.atLeast(gathered_size), gathered_size, 0.0);
  const std::size_t filtered_size = positions_y * static_cast<std::size_t>(out.width);
  std::fill_n(along_columns_.atLeast(filtered_size), filtered_size, 0.0);
  const auto layer_size = static_cast<std::size_t>(out.layerStride());
  const std::size_t n_kept = 2 + 4 * static_cast<std::size_t>(radius_);
  std::fill_n(kept_.atLeast(n_kept * layer_size), layer_size, 0.0);
}

/// Order in memory: one layer of zeros; the first layers of a ring, which its end needs again; a circular buffer
/// of as many layers as the kernel spans.
double* SeparableFilter::keptLayer(const GatherAxis& layers, int position, std::ptrdiff_t layer_size) {
  if (position < layers.first || position >= layers.last) return kept_.data();
  const int on_ring = layers.period > 0 ? position % layers.period : position;
  const int first_layers = 2 * radius_;
  const int slot = on_ring < first_layers ? on_ring : first_layers + on_ring % (2 * radius_ + 1);
  return kept_.data() + (1 + slot) * layer_size;
}

void SeparableFilter::filterPlane(const double* layer, const GatherAxis& rows, int width, double* out) {
  double* const first_row = gathered_.data() + rows.first * gathered_stride_;
  for (std::size_t t = 0; t < taps_.size(); ++t) taps_[t] = first_row + static_cast<std::ptrdiff_t>(t);
  for (int done = 0; done < gathering_.rows(); done += kRowsAtOnce) {
    const int count = std::min(kRowsAtOnce, gathering_.rows() - done);
    kernels_->copy({layer, gathering_.from.data() + done}, {gathered_.data(), gathering_.to.data()}, count,
                   gathering_.segments.data(), gathering_.segmentCount());
    kernels_->convolve(taps_.data(), gathered_stride_,
                       along_columns_.data() + static_cast<std::ptrdiff_t>(rows.first + done) * width, width,
                       count, width, weights_xy_.data(), radius_);
  }
  for (std::size_t t = 0; t < taps_.size(); ++t)
    taps_[t] = along_columns_.data() + static_cast<std::ptrdiff_t>(t) * width;
  kernels_->convolve(taps_.data(), 0, out, 0, 1, static_cast<std::ptrdiff_t>(width) * rows.count,
                     weights_xy_.data(), radius_);
}

}  // namespace ratslam
