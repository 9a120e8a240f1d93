/// Templates cut into blocks of equal size, each its mean in 8 bits, and which of them meet a view at each
/// shift.
///
/// By the triangle inequality the values of a block differ by at least as much as their means: sums of
/// absolute differences (SAD) of blocks bound those of values from below. Blocks lie at fixed places of the
/// template; the view is cut anew for each shift, so that its blocks cover the same values. A block of which
/// a shift compares only a part is left out there, and so are columns and rows that fill no block.
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
  static BlockGrid ofValues(const LocalViewParams& params);

  /// At least 4 blocks along what is compared, 5 bands of them where there are as many rows. Few wide blocks
  /// and many bands tell places apart far better than as many blocks of another shape: rows see the horizon.
  /// Where blocks that all shifts compare cover four fifths of what one does, there are no others.
  static BlockGrid coarse(const LocalViewParams& params);

  /// Means of a template's blocks in 8 bits, column by column. @param values row by row.
  std::vector<std::uint8_t> ofTemplate(const std::vector<double>& values) const;

  /// Means of what the view has opposite the blocks of runs(), for each shift; once where they are the same
  /// for all.
  void ofView(const std::vector<double>& values, std::vector<std::vector<std::uint8_t>>& means) const;

  std::size_t columns() const { return block_columns_; }
  std::size_t rows() const { return rows_ / height_; }
  std::size_t valuesInBlock() const { return width_ * height_; }

  /// First of the view's columns that the lowest shift compares.
  std::size_t firstComparedColumn() const { return first_compared_; }

  /// The blocks that each shift compares.
  const std::vector<BlockRun>& runs() const { return runs_; }

  /// The largest number of blocks that a shift compares.
  std::size_t mostCompared() const;

  /// Whether blocks are single values, of which every shift compares as many, each one column after the last.
  bool slidesByValues() const {
    return valuesInBlock() == 1 && block_columns_ == columns_ && !panoramic_ && step_ == 1;
  }

 private:
  /// Columns of a template or view.
  struct Extent {
    std::size_t begin;
    std::size_t end;
  };
  BlockGrid(const LocalViewParams& params, std::size_t width, std::size_t height, const Extent& cut);
  void columnMeans(const std::vector<double>& values, const Extent& extent, std::size_t step,
                   std::vector<std::uint8_t>& means) const;

  std::size_t columns_;  // of values
  std::size_t rows_;
  std::size_t width_;  // of a block
  std::size_t height_;
  std::size_t step_;
  bool panoramic_;
  std::size_t first_compared_;
  std::size_t first_column_;  // of the first block
  std::size_t block_columns_;
  bool same_at_all_shifts_ = false;  // what of the view meets the blocks
  std::vector<BlockRun> runs_;
  std::vector<std::size_t> view_columns_;  // of the view where the first block of each run begins
};

}  // namespace ratslam
