/// Templates cut into blocks of equal size, each its mean in 8 bits, and which of them meet a view at each
/// shift.
///
/// By the triangle inequality the values of a block differ by at least as much as their means: sums of
/// absolute differences (SAD) of blocks bound those of values from below. Blocks lie at fixed places of the
/// template; the view is cut anew for each shift, so that its blocks cover the same values. What a block does
/// not cover wholly at a shift is left out there, and so are columns and rows that fill no block.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ratslam/local_view/local_view_params.h"

namespace ratslam {

/// Blocks of a template, counted column by column.
struct BlockRun {
  std::size_t begin = 0;
  std::size_t count = 0;
};

class BlockGrid {
 public:
  /// Blocks of a single value.
  static BlockGrid ofValues(const LocalViewParams& params) { return {params, 1, 1}; }

  /// At least 4 blocks along what is compared, 5 bands of them where there are as many rows. Few wide blocks
  /// and many bands tell places apart far better than as many blocks of another shape: rows see the horizon.
  static BlockGrid coarse(const LocalViewParams& params);

  /// Means of a template's blocks in 8 bits, column by column. @param values row by row.
  std::vector<std::uint8_t> ofTemplate(const std::vector<double>& values) const;

  /// Means of what the view has opposite the blocks of runs(), for each shift; once where they are the same
  /// for all.
  void ofView(const std::vector<double>& values, std::vector<std::vector<std::uint8_t>>& means) const;

  std::size_t columns() const { return columns_ / width_; }
  std::size_t rows() const { return rows_ / height_; }
  std::size_t valuesInBlock() const { return width_ * height_; }

  /// The blocks that each shift compares.
  const std::vector<BlockRun>& runs() const { return runs_; }

  /// The largest number of blocks that a shift compares.
  std::size_t mostCompared() const;

  /// Whether blocks are single values, of which every shift compares as many, each one column after the last.
  bool slidesByValues() const { return valuesInBlock() == 1 && !panoramic_ && step_ == 1; }

 private:
  BlockGrid(const LocalViewParams& params, int width, int height);
  void columnMeans(const std::vector<double>& values, std::size_t step, std::size_t count,
                   std::vector<std::uint8_t>& means) const;

  std::size_t columns_;  // of values
  std::size_t rows_;
  std::size_t width_;  // of a block
  std::size_t height_;
  std::size_t step_;
  bool panoramic_;
  std::vector<BlockRun> runs_;
  std::vector<std::size_t> view_columns_;  // of the view where the first block of each run begins
};

}  // namespace ratslam
