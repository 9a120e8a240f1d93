#include "ratslam/local_view/block_grid.h"

#include <algorithm>

#include "ratslam/local_view/view_template.h"

namespace ratslam {
namespace {

constexpr int kBlocksAcross = 5;  // what is compared, of which a shift covers at least 4 wholly
constexpr int kBands = 5;

std::size_t asSize(int value) { return static_cast<std::size_t>(value); }

}  // namespace

BlockGrid::BlockGrid(const LocalViewParams& params, int width, int height)
    : columns_(asSize(params.view_template.x_size)),
      rows_(asSize(params.view_template.y_size)),
      width_(asSize(width)),
      height_(asSize(height)),
      step_(asSize(params.step_match)),
      panoramic_(params.panoramic) {
  const std::size_t compared = asSize(params.comparedColumns());
  const std::size_t first_column = panoramic_ ? 0 : asSize(params.shift_match);
  for (std::size_t i = 0; i < asSize(params.shiftCount()); ++i) {
    const std::size_t begin = panoramic_ ? 0 : i * step_;
    const std::size_t first = (begin + width_ - 1) / width_;
    const std::size_t last = (begin + compared) / width_;
    runs_.push_back({first * rows(), (last - first) * rows()});
    // Column x of the view meets column x + shift of the template.
    view_columns_.push_back((first * width_ + first_column + columns_ - i * step_) % columns_);
  }
}

BlockGrid BlockGrid::coarse(const LocalViewParams& params) {
  return {params, std::max(1, params.comparedColumns() / kBlocksAcross),
          std::max(1, params.view_template.y_size / kBands)};
}

std::size_t BlockGrid::mostCompared() const {
  std::size_t most = 0;
  for (const BlockRun& run : runs_) most = std::max(most, run.count);
  return most;
}

/// Means of the columns of blocks that begin at the columns 0, step, 2 * step ... of the values, which close
/// into a circle.
void BlockGrid::columnMeans(const std::vector<double>& values, std::size_t step, std::size_t count,
                            std::vector<std::uint8_t>& means) const {
  const std::size_t bands = rows();
  means.resize(count * bands);
  std::vector<double> sums(columns_ + width_ - 1);
  std::vector<double> block_sums(columns_);
  std::vector<std::uint8_t> of_band(columns_);
  const double share = 1.0 / static_cast<double>(valuesInBlock());
  const double* row = values.data();
  for (std::size_t band = 0; band < bands; ++band) {
    std::copy_n(row, columns_, sums.begin());
    row += columns_;
    for (std::size_t y = 1; y < height_; ++y, row += columns_) {
      for (std::size_t x = 0; x < columns_; ++x) sums[x] += row[x];
    }
    std::copy_n(sums.begin(), width_ - 1, sums.begin() + static_cast<std::ptrdiff_t>(columns_));
    std::copy_n(sums.begin(), columns_, block_sums.begin());
    for (std::size_t k = 1; k < width_; ++k) {
      for (std::size_t x = 0; x < columns_; ++x) block_sums[x] += sums[x + k];
    }
    for (std::size_t x = 0; x < columns_; ++x) of_band[x] = quantised(block_sums[x] * share);
    std::uint8_t* target = means.data() + band;
    for (std::size_t i = 0; i < count; ++i) target[i * bands] = of_band[i * step];
  }
}

std::vector<std::uint8_t> BlockGrid::ofTemplate(const std::vector<double>& values) const {
  std::vector<std::uint8_t> means;
  columnMeans(values, width_, columns(), means);
  return means;
}

void BlockGrid::ofView(const std::vector<double>& values,
                       std::vector<std::vector<std::uint8_t>>& means) const {
  std::vector<std::uint8_t> at_column;  // of the blocks that begin at each column of the view
  columnMeans(values, 1, columns_, at_column);
  const bool same_at_all_shifts = width_ == 1 && !panoramic_;
  means.resize(same_at_all_shifts ? 1 : runs_.size());
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
