/// Division of templates into blocks of equal size. Each block has its mean in 8 bits. The grid also states which
/// blocks are compared at each shift.
///
/// By the triangle inequality the sum of absolute differences (SAD) of the block means is a lower bound for the SAD
/// of the values. Blocks have fixed positions in the template. The view is divided again for each shift, so that its
/// blocks cover the same values. At a shift that compares only a part of a block, the block is left out. So are
/// columns and rows that do not fill a block.
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

  /// A coarse grid: at least 4 blocks along the compared columns, and 5 bands of rows if there are as many. Few wide
  /// blocks in many bands distinguish places much better than other shapes, because of the horizon. If the blocks
  /// common to all shifts cover four fifths of the compared columns, only they are used.
  static BlockGrid coarse(const LocalViewParams& params);

  /// Means of a template's blocks in 8 bits, column by column. @param values row by row.
  std::vector<std::uint8_t> ofTemplate(const std::vector<double>& values) const;

  /// Means of the view opposite the blocks of runs(), for each shift; only once if they are the same for all shifts.
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

  /// Whether blocks are single values, all columns have blocks, and shifts are one column apart.
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
  bool same_at_all_shifts_ = false;  // whether the same part of the view is compared at all shifts
  std::vector<BlockRun> runs_;
  std::vector<std::size_t> view_columns_;  // column of the view at the first block of each run
};

}  // namespace ratslam
