#include "ratslam/local_view/block_sad/block_grid.h"

#include <algorithm>
#include <numeric>

#include "ratslam/local_view/block_sad/view_template.h"

namespace ratslam {
namespace {

constexpr std::size_t kBlocksAcross =
    5;  // blocks along the compared columns; a shift covers at least 4 of them
constexpr std::size_t kBands = 5;

std::size_t asSize(int value) { return static_cast<std::size_t>(value); }

/// Sums of `count` consecutive values from each value on, on a circle. They are differences of sums from the first value
/// on. For count 1 the results are the values, to the last bit.
void sumNeighbours(const std::vector<double>& values, std::size_t count, std::vector<double>& sums) {
  sums = values;
  if (count == 1) return;
  std::vector<double> from_first(values.size() + count, 0.0);
  const auto end = std::partial_sum(values.begin(), values.end(), from_first.begin() + 1);
  const double circle = end[-1];
  const auto counted = from_first.begin() + static_cast<std::ptrdiff_t>(count);
  std::transform(from_first.begin() + 1, counted, end, [circle](double sum) { return circle + sum; });
  std::transform(from_first.begin(), end - 1, counted, sums.begin(),
                 [](double before, double until) { return std::max(until - before, 0.0); });
}

}  // namespace

BlockGrid::BlockGrid(const LocalViewParams& params, std::size_t width, std::size_t height, const Extent& cut)
    : columns_(asSize(params.view_template.x_size)),
      rows_(asSize(params.view_template.y_size)),
      width_(width),
      height_(height),
      step_(asSize(params.step_match)),
      panoramic_(params.panoramic),
      first_compared_(panoramic_ ? 0 : asSize(params.shift_match)),
      first_column_(cut.begin),
      block_columns_((cut.end - cut.begin) / width) {
  const std::size_t compared = asSize(params.comparedColumns());
  for (std::size_t i = 0; i < asSize(params.shiftCount()); ++i) {
    const std::size_t begin = panoramic_ ? 0 : i * step_;
    const std::size_t end = begin + compared;
    const std::size_t first = begin > cut.begin ? (begin - cut.begin + width_ - 1) / width_ : 0;
    const std::size_t last = std::min((end - cut.begin) / width_, block_columns_);
    runs_.push_back({first * rows(), (last - first) * rows()});
    // Column x of the view is compared with column x + shift of the template.
    view_columns_.push_back((cut.begin + first * width_ + first_compared_ + columns_ - i * step_) % columns_);
  }
  const auto is_first = [&](std::size_t column) { return column == view_columns_.front(); };
  same_at_all_shifts_ = width_ == 1 && std::all_of(view_columns_.begin(), view_columns_.end(), is_first);
}

BlockGrid BlockGrid::ofValues(const LocalViewParams& params) {
  return {params, 1, 1, {0, asSize(params.view_template.x_size)}};
}

BlockGrid BlockGrid::coarse(const LocalViewParams& params) {
  const std::size_t columns = asSize(params.view_template.x_size);
  const std::size_t compared = asSize(params.comparedColumns());
  const std::size_t width = std::max<std::size_t>(1, compared / kBlocksAcross);
  const std::size_t height = std::max<std::size_t>(1, asSize(params.view_template.y_size) / kBands);
  const std::size_t by_highest_shift = params.panoramic ? 0 : columns - compared;  // first compared column
  const std::size_t by_all_shifts = compared > by_highest_shift ? compared - by_highest_shift : 0;
  const bool enough = by_all_shifts / width * width * kBlocksAcross >= (kBlocksAcross - 1) * compared;
  return {params, width, height, enough ? Extent{by_highest_shift, compared} : Extent{0, columns}};
}

std::size_t BlockGrid::mostCompared() const {
  std::size_t most = 0;
  for (const BlockRun& run : runs_) most = std::max(most, run.count);
  return most;
}

/// Means of the blocks that begin at every step-th column of the extent and lie within it. The values close into a circle.
void BlockGrid::columnMeans(const std::vector<double>& values, const Extent& extent, std::size_t step,
                            std::vector<std::uint8_t>& means) const {
  const std::size_t bands = rows();
  const std::size_t count = (extent.end - extent.begin - width_) / step + 1;
  means.resize(count * bands);
  std::vector<double> column_sums(columns_);
  std::vector<double> sums;
  std::vector<std::uint8_t> of_band(columns_);
  const double share = 1.0 / static_cast<double>(valuesInBlock());
  const double* row = values.data();
  for (std::size_t band = 0; band < bands; ++band) {
    std::copy_n(row, columns_, column_sums.begin());
    row += columns_;
    for (std::size_t y = 1; y < height_; ++y, row += columns_) {
      for (std::size_t x = 0; x < columns_; ++x) column_sums[x] += row[x];
    }
    sumNeighbours(column_sums, width_, sums);
    std::transform(sums.begin(), sums.end(), of_band.begin(),
                   [share](double sum) { return quantised(sum * share); });
    std::uint8_t* target = means.data() + band;
    const std::uint8_t* source = of_band.data() + extent.begin;
    for (std::size_t i = 0; i < count; ++i) target[i * bands] = source[i * step];
  }
}

std::vector<std::uint8_t> BlockGrid::ofTemplate(const std::vector<double>& values) const {
  std::vector<std::uint8_t> means;
  columnMeans(values, {first_column_, first_column_ + block_columns_ * width_}, width_, means);
  return means;
}

void BlockGrid::ofView(const std::vector<double>& values,
                       std::vector<std::vector<std::uint8_t>>& means) const {
  std::vector<std::uint8_t> at_column;  // means of the blocks that begin at each column of the view
  columnMeans(values, {0, columns_ + width_ - 1}, 1, at_column);
  means.resize(same_at_all_shifts_ ? 1 : runs_.size());
  for (std::size_t shift = 0; shift < means.size(); ++shift) {
    std::size_t column = view_columns_[shift];
    means[shift].resize(runs_[shift].count);
    for (auto next = means[shift].begin(); next != means[shift].end();) {
      const auto first = at_column.begin() + static_cast<std::ptrdiff_t>(column * rows());
      const std::size_t left = static_cast<std::size_t>(means[shift].end() - next);
      next = std::copy_n(first, width_ > 1 ? rows() : std::min(left, (columns_ - column) * rows()), next);
      column = width_ > 1 ? (column + width_) % columns_ : 0;
    }
  }
}

}  // namespace ratslam
