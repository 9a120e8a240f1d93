#include "ratslam/pose_cells/path_integration.h"

#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"

namespace ratslam {
namespace {

/// Distribution of activity after `n` shifts on a ring of `size` cells. Each shift moves the share `moved` by one
/// cell. The weights are the coefficients of ((1 - moved) + moved z)^n with z^size = 1.
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
    for (double& weight : result) weight /= sum;  // otherwise rounding would grow with every squaring
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
  // Packets farther apart than this neither read each other's cells nor reach the same cells.
  const std::vector<Box> boxes = coalesced(grid.boxes(), grid.sizes(), 2 * motion.reach + 1);
  if (packets_.size() < boxes.size()) packets_.resize(boxes.size());
  lost_ = 0.0;
  for (std::size_t b = 0; b < boxes.size(); ++b) shiftLayers(grid, boxes[b], motion, packets_[b]);
  // The remaining sum follows from the loss, without a pass over the cells. If little remains, that would be
  // inaccurate.
  const bool mostly_kept = lost_ < 0.5 * sum;
  const double scale = mostly_kept ? 1.0 / (sum - lost_) : 1.0;
  const bool all_cells = boxes.size() == 1 && grid.isWhole(packets_[0].target);  // every cell will be written
  if (!all_cells) grid.clear();
  std::vector<Box> targets;
  for (std::size_t b = 0; b < boxes.size(); ++b) {
    rotateInto(grid, packets_[b], motion, scale, all_cells ? kernels_->blend : kernels_->addBlend);
    targets.push_back(packets_[b].target);
  }
  grid.replaceBoxes(targets);
  if (mostly_kept) return (sum - lost_) / sum;
  const double kept = grid.sum();
  if (kept > 0.0) {
    grid.scale(1.0 / kept);
  } else {
    grid.clear();
  }
  return kept / sum;
}

void PathIntegrator::setExtent(const Box& box, std::size_t axis, const std::vector<double>& heading,
                               const Motion& motion, Extent& extent) const {
  const Span& span = box[axis];
  const int size = params_.n_xy;
  int up = 0;  // largest motion to higher and to lower cells: all layers may move to the same side
  int down = 0;
  for (int c = 0; c < box[kLayer].length; ++c) {
    const auto k = static_cast<std::size_t>(wrapIndex(box[kLayer].begin + c, params_.n_th));
    (motion.cells * heading[k] < 0.0 ? down : up) = motion.reach;
  }
  extent.ring = span.length + 2 * motion.reach >= size;
  extent.origin = extent.ring ? 0 : wrapIndex(span.begin - down, size);
  extent.count = extent.ring ? size : span.length + down + up;
  if (extent.ring) {
    extent.gather.set(0, size, motion.reach, size, true, 0, size);
  } else {
    extent.gather.set(-down, extent.count, motion.reach, span.length, false, span.begin, size);
  }
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

void PathIntegrator::shiftLayers(const ActivityGrid& grid, const Box& box, const Motion& motion,
                                 Packet& packet) {
  setExtent(box, kColumn, cos_heading_, motion, columns_);
  setExtent(box, kRow, sin_heading_, motion, rows_);
  packet.row_stride = paddedWidth(columns_.gather.positions());
  packet.layer_stride = packet.row_stride * rows_.count;
  moving_.planGathering(columns_.gather, rows_.gather, static_cast<std::ptrdiff_t>(grid.offset(0, 1)),
                        packet.row_stride);
  const auto gathered_size = static_cast<std::size_t>(packet.row_stride * rows_.gather.positions());
  std::fill_n(gathered_.atLeast(gathered_size), gathered_size, 0.0);

  const Span& layers = box[kLayer];
  const bool all_layers = layers.length == grid.nTh();
  double* const before_first =
      packet.layers.atLeast(static_cast<std::size_t>(packet.layer_stride * (layers.length + 2)));
  double* const first = before_first + packet.layer_stride;
  double* const behind_last = first + packet.layer_stride * layers.length;
  for (int c = 0; c < layers.length; ++c) {
    const int k = wrapIndex(layers.begin + c, grid.nTh());
    kernels_->copy({grid.data() + grid.offset(k, 0), moving_.from.data()},
                   {gathered_.data(), moving_.to.data()}, moving_.rows(), moving_.segments.data(),
                   moving_.segmentCount());
    shiftLayer(k, motion, packet.row_stride, first + c * packet.layer_stride);
  }
  std::fill_n(behind_last, packet.layer_stride, 0.0);
  if (all_layers) {
    std::copy_n(behind_last - packet.layer_stride, packet.layer_stride, before_first);
  } else {
    std::fill_n(before_first, packet.layer_stride, 0.0);
  }
  packet.target = {Span{columns_.origin, columns_.count}, Span{rows_.origin, rows_.count},
                   Span{wrapIndex(layers.begin + motion.whole_layers, grid.nTh()),
                        all_layers ? layers.length : layers.length + 1}};
}

void PathIntegrator::shiftLayer(int k, const Motion& motion, std::ptrdiff_t row_stride, double* shifted) {
  const auto layer = static_cast<std::size_t>(k);
  setShift(motion.cells * cos_heading_[layer], motion, params_.n_xy, shift_x_);
  setShift(motion.cells * sin_heading_[layer], motion, params_.n_xy, shift_y_);
  const std::ptrdiff_t size = row_stride * rows_.count;
  const int taps = motion.reach + 1;
  // The last rows read past their end by the reach. These values fall into unused columns.
  double* const along_y = along_y_.atLeast(static_cast<std::size_t>(size + 2 * taps + kRowQuantum));
  kernels_->correlate(gathered_.data() + motion.reach * row_stride, -shift_y_.sign * row_stride, along_y,
                      size, shift_y_.weights.data(), taps);
  kernels_->correlate(along_y + motion.reach, -shift_x_.sign, shifted, size, shift_x_.weights.data(), taps);
  if (params_.openratslam_corner && motion.sub_steps == 1.0) loseAtCorner(k, motion, row_stride, shifted);
}

/// The quadrant of the direction selects the corner, and not the signs of its components: OpenRatSLAM turns a
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

void PathIntegrator::rotateInto(ActivityGrid& grid, const Packet& packet, const Motion& motion, double scale,
                                RowKernels::Blend blend) {
  const Box& target = packet.target;
  moving_.clear();
  moving_.appendColumns(
      target[kColumn].length, [](int c) { return c; },
      [&](int c) { return wrapIndex(target[kColumn].begin + c, grid.nXy()); });
  for (int b = 0; b < target[kRow].length; ++b)
    moving_.appendRow(b * packet.row_stride, static_cast<std::ptrdiff_t>(grid.offset(
                                                 0, wrapIndex(target[kRow].begin + b, grid.nXy()))));
  const std::array<double, 2> weights{(1.0 - motion.part_layer) * scale, motion.part_layer * scale};
  for (int c = 0; c < target[kLayer].length; ++c)
    blend({packet.layers.data() + (c + 1) * packet.layer_stride, moving_.from.data()}, -packet.layer_stride,
          weights.data(),
          {grid.data() + grid.offset(wrapIndex(target[kLayer].begin + c, grid.nTh()), 0), moving_.to.data()},
          moving_.rows(), moving_.segments.data(), moving_.segmentCount());
}

}  // namespace ratslam
