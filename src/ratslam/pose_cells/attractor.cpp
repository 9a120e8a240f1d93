#include "ratslam/pose_cells/attractor.h"

#include <algorithm>

namespace ratslam {
namespace {

constexpr std::array<std::size_t, 3> kAxes{kColumn, kRow, kLayer};

}  // namespace

Attractor::Attractor(const PoseCellParams& params, SimdLevel level)
    : global_inhibition_(params.global_inhibition),
      kernels_(&rowKernels(level)),
      excitation_(params.excitation_dim, params.excitation_var, params.excitationVarTh(), *kernels_),
      inhibition_(params.inhibition_dim, params.inhibition_var, params.inhibitionVarTh(), *kernels_),
      reach_(2 * excitation_.radius() + inhibition_.radius()) {}

double Attractor::iterate(ActivityGrid& grid, double model_sum) {
  const double phi = global_inhibition_ / model_sum;
  const std::vector<Box> packets = coalesced(grid.boxes(), grid.sizes(), reach_);
  std::array<double, kRowQuantum> sums{};
  std::vector<Box> left;
  for (const Box& packet : packets) {
    excite(grid, packet);
    const bool any_left = findCore(phi);
    if (!any_left || !coreCovers(packet)) grid.zero(packet);
    if (!any_left) continue;
    inhibit(phi, sums.data(), grid);
    for (const Box& box : occupiedBoxes(grid)) left.push_back(box);
  }
  grid.replaceBoxes(left);
  double sum = 0.0;
  for (const double partial : sums) sum += partial;
  return sum;
}

void Attractor::AxisMaxima::reset(const std::array<GatherAxis, 3>& axes) {
  const auto rows = static_cast<std::size_t>(axes[kRow].count);
  columns_.assign(static_cast<std::size_t>(paddedWidth(axes[kColumn].count)), 0.0);
  row_lanes_.assign(rows * kRowQuantum, 0.0);
  rows_.assign(rows, 0.0);
  layers_.assign(static_cast<std::size_t>(axes[kLayer].count), 0.0);
}

void Attractor::AxisMaxima::finish() {
  for (std::size_t j = 0; j < rows_.size(); ++j) {
    const double* const lanes = row_lanes_.data() + j * kRowQuantum;
    rows_[j] = *std::max_element(lanes, lanes + kRowQuantum);
  }
}

const double* Attractor::AxisMaxima::along(std::size_t axis) const {
  return axis == kColumn ? columns_.data() : axis == kRow ? rows_.data() : layers_.data();
}

void Attractor::excite(const ActivityGrid& grid, const Box& packet) {
  const int radius = excitation_.radius();
  for (const std::size_t axis : kAxes) {
    Extent& extent = extents_[axis];
    const Span& span = packet[axis];
    const int size = grid.sizes()[axis];
    extent.ring = span.length + reach_ > size;
    extent.origin = extent.ring ? 0 : wrapIndex(span.begin - radius, size);
    extent.count = extent.ring ? size : span.length + 2 * radius;
    if (extent.ring) {
      axes_[axis].set(0, size, radius, size, true, 0, size);
    } else {
      axes_[axis].set(-radius, extent.count, radius, span.length, false, span.begin, size);
    }
  }
  excited_.resize({extents_[kColumn].count, extents_[kRow].count, extents_[kLayer].count});
  maxima_.reset(axes_);
  const bool rings_only =
      std::all_of(extents_.begin(), extents_.end(), [](const Extent& e) { return e.ring; });
  const auto row_stride = static_cast<std::ptrdiff_t>(grid.offset(0, 1));
  const auto layer_stride = static_cast<std::ptrdiff_t>(grid.offset(1, 0));
  excitation_.apply({grid.data(), layer_stride, row_stride}, axes_, excited_, [&](int k) {
    if (rings_only) return;  // whole rings cannot be narrowed
    maxima_.setLayer(k, kernels_->findMaxima(excited_.layer(k), excited_.counts[kRow], excited_.width,
                                             maxima_.forLayers()));
  });
  maxima_.finish();
}

bool Attractor::findCore(double phi) {
  for (const std::size_t axis : kAxes) {
    Extent& extent = extents_[axis];
    extent.core = {0, extent.count};
    if (extent.ring) continue;
    const double* const begin = maxima_.along(axis);
    const double* const end = begin + extent.count;
    const auto may_survive = [phi](double largest) { return largest > phi; };
    const double* const first = std::find_if(begin, end, may_survive);
    if (first == end) return false;
    const double* last = end;
    while (!may_survive(*(last - 1))) --last;
    extent.core = {static_cast<int>(first - begin), static_cast<int>(last - first)};
  }
  return true;
}

bool Attractor::coreCovers(const Box& packet) const {
  return std::all_of(kAxes.begin(), kAxes.end(), [&](std::size_t axis) {
    const Extent& extent = extents_[axis];
    const int begin = excitation_.radius();  // of the packet within the excited box
    return extent.ring || (extent.core.begin <= begin &&
                           extent.core.begin + extent.core.length >= begin + packet[axis].length);
  });
}

void Attractor::inhibit(double phi, double* sums, ActivityGrid& grid) {
  for (const std::size_t axis : kAxes) {
    const Extent& extent = extents_[axis];
    axes_[axis].set(extent.core.begin, extent.core.length, inhibition_.radius(), extent.count, extent.ring, 0,
                    extent.count);
  }
  core_.resize({axes_[kColumn].count, axes_[kRow].count, 1});
  maxima_.reset(axes_);
  planStoring(grid);
  long long* const keep = keep_.atLeast(static_cast<std::size_t>(core_.width));
  for (int x = 0; x < core_.width; ++x) keep[x] = x < core_.counts[kColumn] ? -1 : 0;
  const CellSource excited = excited_.source();
  const double* const first_excited = excited.cells + extents_[kLayer].core.begin * excited.layer_stride +
                                      extents_[kRow].core.begin * excited.row_stride +
                                      extents_[kColumn].core.begin;
  inhibition_.apply(excited, axes_, core_, [&](int k) {
    maxima_.setLayer(
        k, kernels_->inhibit(first_excited + k * excited.layer_stride, excited.row_stride, core_.layer(k),
                             core_.counts[kRow], core_.width, phi, keep, sums, maxima_.forLayers()));
    kernels_->copy({core_.layer(k), storing_.from.data()},
                   {grid.data() + grid.offset(inGrid(grid, kLayer, k), 0), storing_.to.data()},
                   storing_.rows(), storing_.segments.data(), storing_.segmentCount());
  });
  maxima_.finish();
}

int Attractor::inGrid(const ActivityGrid& grid, std::size_t axis, int c) const {
  return wrapIndex(extents_[axis].origin + extents_[axis].core.begin + c, grid.sizes()[axis]);
}

void Attractor::planStoring(const ActivityGrid& grid) {
  storing_.clear();
  storing_.appendColumns(
      core_.counts[kColumn], [](int c) { return c; }, [&](int c) { return inGrid(grid, kColumn, c); });
  for (int b = 0; b < core_.counts[kRow]; ++b)
    storing_.appendRow(static_cast<std::ptrdiff_t>(b) * core_.width,
                       static_cast<std::ptrdiff_t>(grid.offset(0, inGrid(grid, kRow, b))));
}

std::vector<Box> Attractor::occupiedBoxes(const ActivityGrid& grid) const {
  std::array<std::vector<Span>, 3> spans;
  for (const std::size_t axis : kAxes) {
    spans[axis] = occupiedSpans(maxima_.along(axis), axes_[axis].count, extents_[axis].ring, reach_);
    for (Span& span : spans[axis]) span.begin = inGrid(grid, axis, span.begin);
  }
  std::vector<Box> boxes;
  for (const Span& layers : spans[kLayer])
    for (const Span& rows : spans[kRow])
      for (const Span& columns : spans[kColumn]) boxes.push_back({columns, rows, layers});
  if (boxes.size() > 1)
    boxes.erase(std::remove_if(boxes.begin(), boxes.end(), [&](Box& box) { return !tighten(grid, box); }),
                boxes.end());
  return boxes;
}

/// Shrinks a box to its activity. @return false if there is none.
bool Attractor::tighten(const ActivityGrid& grid, Box& box) {
  std::array<int, 3> low{box[kColumn].length, box[kRow].length, box[kLayer].length};
  std::array<int, 3> high{-1, -1, -1};
  const auto wrapped = [&](std::size_t axis, int c) {
    return wrapIndex(box[axis].begin + c, grid.sizes()[axis]);
  };
  for (int c = 0; c < box[kLayer].length; ++c)
    for (int b = 0; b < box[kRow].length; ++b) {
      const double* const row = grid.data() + grid.offset(wrapped(kLayer, c), wrapped(kRow, b));
      for (int a = 0; a < box[kColumn].length; ++a) {
        if (!(row[wrapped(kColumn, a)] > 0.0)) continue;
        const std::array<int, 3> cell{a, b, c};
        for (const std::size_t axis : kAxes) {
          low[axis] = std::min(low[axis], cell[axis]);
          high[axis] = std::max(high[axis], cell[axis]);
        }
      }
    }
  if (high[kColumn] < 0) return false;
  for (const std::size_t axis : kAxes) box[axis] = {wrapped(axis, low[axis]), high[axis] - low[axis] + 1};
  return true;
}

}  // namespace ratslam
