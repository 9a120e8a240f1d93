#include "ratslam/pose_cells/path_integration.h"

#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"

namespace ratslam {
namespace {

/// Weights of where activity is after `n` shifts that each take a share `moved` of it one cell on, on a ring
/// of `size` cells: the coefficients of ((1 - moved) + moved z)^n, z^size = 1.
std::vector<double> repeatedShift(double moved, double n, int size) {
  const auto length = static_cast<std::size_t>(size);
  const auto product = [length](const std::vector<double>& a, const std::vector<double>& b) {
    std::vector<double> result(length, 0.0);
    double sum = 0.0;
    for (std::size_t i = 0; i < length; ++i)
      for (std::size_t j = 0; j < length; ++j) {
        result[(i + j) % length] += a[i] * b[j];
        sum += a[i] * b[j];
      }
    for (double& weight : result) weight /= sum;  // else rounding would grow with every squaring
    return result;
  };
  std::vector<double> power(length, 0.0);
  power[0] = 1.0;
  std::vector<double> square(length, 0.0);
  square[0] += 1.0 - moved;
  square[1 % length] += moved;
  for (double left = n; left >= 1.0; left = std::floor(left / 2.0)) {
    if (std::fmod(left, 2.0) != 0.0) power = product(power, square);
    square = product(square, square);
  }
  return power;
}

}  // namespace

PathIntegrator::PathIntegrator(const PoseCellParams& params, SimdLevel level)
    : params_(params), kernels_(&rowKernels(level)) {
  for (int k = 0; k < params.n_th; ++k) {
    const double heading = k * 2.0 * kPi / params.n_th;
    cos_heading_.push_back(std::cos(heading));
    sin_heading_.push_back(std::sin(heading));
  }
}

void PathIntegrator::check(double distance, double rotation) const {
  if (!std::isfinite(distance / params_.cell_size)) throwBadValue("distance", distance, "it must be finite");
  if (!std::isfinite(rotation)) throwBadValue("rotation", rotation, "it must be finite");
}

PathIntegrator::Motion PathIntegrator::motionOf(double distance, double rotation) const {
  Motion motion;
  const double cells = distance / params_.cell_size;
  motion.sub_steps = std::ceil(std::abs(cells));
  if (motion.sub_steps > 0.0) motion.cells = cells / motion.sub_steps;
  motion.reach = static_cast<int>(std::min(motion.sub_steps, params_.n_xy - 1.0));
  const double layers = wrapAngle(rotation) * params_.n_th / (2.0 * kPi);
  motion.whole_layers = static_cast<int>(std::floor(layers));
  motion.part_layer = layers - motion.whole_layers;
  return motion;
}

double PathIntegrator::integrate(ActivityGrid& grid, double distance, double rotation, double sum) {
  const Motion motion = motionOf(distance, rotation);
  // Packets farther apart than this cannot show up in each other's rows, nor arrive at the same cells.
  const std::vector<Box> boxes = coalesced(grid.boxes(), grid.sizes(), 2 * motion.reach + 1);
  if (packets_.size() < boxes.size()) packets_.resize(boxes.size());
  lost_ = 0.0;
  for (std::size_t b = 0; b < boxes.size(); ++b) move(grid, boxes[b], motion, 1.0 / sum, packets_[b]);
  grid.clear();
  std::vector<Box> targets;
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    addToGrid(packets_[b], grid);
    targets.push_back(packets_[b].target);
  }
  grid.replaceBoxes(targets);
  if (!(lost_ > 0.0)) return 1.0;
  const double kept = grid.sum();
  if (kept > 0.0) {
    grid.scale(1.0 / kept);
  } else {
    grid.clear();
  }
  return kept;
}

GatherAxis PathIntegrator::gatherAxis(const Span& span, const Motion& motion, int size, Extent& extent) {
  extent.ring = span.length + 2 * motion.reach >= size;
  extent.origin = extent.ring ? 0 : wrapIndex(span.begin - motion.reach, size);
  extent.count = extent.ring ? size : span.length + 2 * motion.reach;
  return extent.ring
             ? GatherAxis(0, size, motion.reach, size, true, 0, size)
             : GatherAxis(-motion.reach, extent.count, motion.reach, span.length, false, span.begin, size);
}

void PathIntegrator::setShift(double cells, const Motion& motion, int size, Shift& shift) {
  shift.sign = cells < 0.0 ? -1 : 1;
  const double moved = std::abs(cells);
  if (motion.sub_steps > 1.0) {
    shift.weights = repeatedShift(moved, motion.sub_steps, size);
    shift.weights.resize(static_cast<std::size_t>(motion.reach) + 1);
  } else if (motion.reach == 1) {
    shift.weights.assign({1.0 - moved, moved});
  } else {
    shift.weights.assign({1.0});  // no motion, or a ring of one cell
  }
}

void PathIntegrator::move(const ActivityGrid& grid, const Box& box, const Motion& motion, double scale,
                          Packet& packet) {
  const GatherAxis columns = gatherAxis(box[kColumn], motion, grid.nXy(), columns_);
  const GatherAxis rows = gatherAxis(box[kRow], motion, grid.nXy(), rows_);
  const std::ptrdiff_t row_stride = paddedWidth(static_cast<int>(columns.sources.size()));
  const auto gathered_size = static_cast<std::size_t>(row_stride) * rows.sources.size();
  segments_.clear();
  appendSegments(
      segments_, columns.last - columns.first, [&](int c) { return columns.source(columns.first + c); },
      [&](int c) { return columns.first + c; });
  from_.clear();
  to_.clear();
  for (int p = rows.first; p < rows.last; ++p) {
    from_.push_back(static_cast<std::ptrdiff_t>(grid.offset(0, rows.source(p))));
    to_.push_back(p * row_stride);
  }
  std::fill_n(gathered_.atLeast(gathered_size), gathered_size, 0.0);

  const Span& layers = box[kLayer];
  const bool all_layers = layers.length == grid.nTh();
  const std::ptrdiff_t layer_size = row_stride * rows_.count;
  double* const before_first = shifted_.atLeast(static_cast<std::size_t>(layer_size * (layers.length + 2)));
  double* const first = before_first + layer_size;
  double* const behind_last = first + layer_size * layers.length;
  for (int c = 0; c < layers.length; ++c) {
    const int k = wrapIndex(layers.begin + c, grid.nTh());
    kernels_->copy({grid.data() + grid.offset(k, 0), from_.data()}, {gathered_.data(), to_.data()},
                   static_cast<int>(from_.size()), segments_.data(), static_cast<int>(segments_.size()));
    shiftLayer(k, motion, row_stride, first + c * layer_size);
  }
  std::fill_n(behind_last, layer_size, 0.0);
  if (all_layers) {
    std::copy_n(behind_last - layer_size, layer_size, before_first);
  } else {
    std::fill_n(before_first, layer_size, 0.0);
  }

  const int arriving_layers = all_layers ? layers.length : layers.length + 1;
  const std::array<double, 2> weights{(1.0 - motion.part_layer) * scale, motion.part_layer * scale};
  kernels_->correlate(first, -layer_size,
                      packet.cells.atLeast(static_cast<std::size_t>(layer_size * arriving_layers)),
                      layer_size * arriving_layers, weights.data(), 2);
  packet.row_stride = row_stride;
  packet.target = {Span{columns_.origin, columns_.count}, Span{rows_.origin, rows_.count},
                   Span{wrapIndex(layers.begin + motion.whole_layers, grid.nTh()), arriving_layers}};
}

void PathIntegrator::shiftLayer(int k, const Motion& motion, std::ptrdiff_t row_stride, double* shifted) {
  const auto layer = static_cast<std::size_t>(k);
  setShift(motion.cells * cos_heading_[layer], motion, params_.n_xy, shift_x_);
  setShift(motion.cells * sin_heading_[layer], motion, params_.n_xy, shift_y_);
  const std::ptrdiff_t size = row_stride * rows_.count;
  const int taps = motion.reach + 1;
  // The last rows look past their end by the reach; what they find there falls into unused columns.
  double* const along_y = along_y_.atLeast(static_cast<std::size_t>(size + 2 * taps + kRowQuantum));
  kernels_->correlate(gathered_.data() + motion.reach * row_stride, -shift_y_.sign * row_stride, along_y,
                      size, shift_y_.weights.data(), taps);
  kernels_->correlate(along_y + motion.reach, -shift_x_.sign, shifted, size, shift_x_.weights.data(), taps);
  if (params_.openratslam_corner && motion.sub_steps == 1.0) loseAtCorner(k, motion, row_stride, shifted);
}

/// The direction's quadrant, not the signs of its components, says which corner it is: OpenRatSLAM turns a
/// layer by whole quadrants before it shifts it.
void PathIntegrator::loseAtCorner(int k, const Motion& motion, std::ptrdiff_t row_stride, double* shifted) {
  const int quadrant = (4 * k / params_.n_th + (motion.cells < 0.0 ? 2 : 0)) % 4;
  const int sign_x = quadrant == 0 || quadrant == 3 ? 1 : -1;
  const int sign_y = quadrant < 2 ? 1 : -1;
  const int last = params_.n_xy - 1;
  const int column = wrapIndex((sign_x > 0 ? 0 : last) - columns_.origin, params_.n_xy);
  const int row = wrapIndex((sign_y > 0 ? 0 : last) - rows_.origin, params_.n_xy);
  if (column >= columns_.count || row >= rows_.count) return;

  const double* const here = gathered_.data() + (row + motion.reach) * row_stride + column + motion.reach;
  const std::ptrdiff_t from_x = -sign_x * motion.reach;
  const std::ptrdiff_t from_y = -sign_y * motion.reach * row_stride;
  const double moved_x = std::abs(motion.cells * cos_heading_[static_cast<std::size_t>(k)]);
  const double moved_y = std::abs(motion.cells * sin_heading_[static_cast<std::size_t>(k)]);
  const double lost = moved_x * (1.0 - moved_y) * here[from_x] + (1.0 - moved_x) * moved_y * here[from_y];
  if (!(lost > 0.0)) return;
  lost_ += lost;
  shifted[row * row_stride + column] =
      (1.0 - moved_x) * (1.0 - moved_y) * here[0] + moved_x * moved_y * here[from_x + from_y];
}

void PathIntegrator::addToGrid(const Packet& packet, ActivityGrid& grid) {
  const Box& target = packet.target;
  segments_.clear();
  appendSegments(
      segments_, target[kColumn].length, [](int c) { return c; },
      [&](int c) { return wrapIndex(target[kColumn].begin + c, grid.nXy()); });
  from_.clear();
  to_.clear();
  for (int c = 0; c < target[kLayer].length; ++c)
    for (int b = 0; b < target[kRow].length; ++b) {
      from_.push_back((static_cast<std::ptrdiff_t>(c) * target[kRow].length + b) * packet.row_stride);
      to_.push_back(static_cast<std::ptrdiff_t>(grid.offset(wrapIndex(target[kLayer].begin + c, grid.nTh()),
                                                            wrapIndex(target[kRow].begin + b, grid.nXy()))));
    }
  kernels_->add({packet.cells.data(), from_.data()}, {grid.data(), to_.data()},
                static_cast<int>(from_.size()), segments_.data(), static_cast<int>(segments_.size()));
}

}  // namespace ratslam
