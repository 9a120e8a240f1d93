/// Templates as 8-bit blocks (block_grid.h), stored for fast sums of absolute differences (SAD) with a view at many
/// shifts. If blocks are single values, these are the SADs of all values.
///
/// Templates are kept in groups of 8 with interleaved bytes (sad_kernels.h). Groups are kept in segments that never
/// move, so that adding costs O(1). The bytes of a group are in column order: then the columns that one shift
/// compares are one run of bytes. A faster kernel needs row order (sliding_sad.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "ratslam/local_view/block_sad/block_grid.h"
#include "ratslam/simd/simd_level.h"

namespace ratslam {

class SadIndex {
 public:
  SadIndex(BlockGrid grid, SimdLevel level);
  ~SadIndex();
  SadIndex(SadIndex&&) noexcept;
  SadIndex& operator=(SadIndex&&) noexcept;

  /// @param values of a template, row by row.
  void add(const std::vector<double>& values);

  /// The blocks of template `id`, row by row.
  std::vector<std::uint8_t> bytes(std::size_t id) const;

  std::size_t groupCount() const;

  const BlockGrid& grid() const { return grid_; }

  /// Sets the view of the next searches. @param values row by row.
  void setView(const std::vector<double>& values);

  /// For each template of the groups [first, last), its smallest SAD over all shifts. The last group may be partly
  /// empty; values of missing templates are undefined. @param smallest 8 values per group.
  void smallestSads(std::size_t first, std::size_t last, std::uint32_t* smallest) const;

  std::size_t memoryBytes() const;

 private:
  struct alignas(64) Chunk {
    std::uint8_t bytes[64];
  };
  struct View;

  void placeByColumns();
  void placeByRows();
  std::size_t blockShift(std::size_t position) const;
  std::uint8_t* firstByteOf(std::size_t id) const;

  BlockGrid grid_;
  std::size_t group_chunks_ = 0;
  std::size_t segment_groups_ = 1;
  std::vector<std::uint32_t> places_;  // position of each byte of the first template in a group
  std::size_t size_ = 0;
  std::vector<std::unique_ptr<Chunk[]>> segments_;
  std::unique_ptr<View> view_;
};

}  // namespace ratslam
