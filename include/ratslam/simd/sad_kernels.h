/// Sums of absolute differences (SAD) of bytes between one view and groups of 8 templates.
///
/// A group interleaves its templates in chunks of 64 bytes: 8 bytes of the first template, the same 8 of the second, and
/// so on. So one instruction compares the same part of several templates with the view, and each template's sum stays in
/// its own lane.
///
/// The view is stored once for each shift. Shifts are processed in blocks of 4, so that a chunk is loaded once for all of
/// them. In the chunks at the two ends of a block, the bytes that a shift does not compare are masked. In the chunks
/// between them all shifts compare every byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ratslam/simd/simd_level.h"

namespace ratslam {

constexpr std::size_t kGroupLanes = 8;   // templates in a group
constexpr std::size_t kChunkBytes = 64;  // 8 bytes of each template

constexpr std::size_t kBlockShifts = 4;

/// The view at 4 shifts. Of the chunks [begin, end) those in [inner_begin, inner_end) need no mask.
struct ShiftBlock {
  std::size_t begin = 0;
  std::size_t inner_begin = 0;
  std::size_t inner_end = 0;
  std::size_t end = 0;
  /// Of chunk c at shift s: [c * kBlockShifts + s]; 0 for bytes that are not compared.
  std::vector<std::uint64_t> view;
  std::vector<std::uint64_t> mask;  ///< likewise: the bytes that are compared
};

/// A view at all shifts, and the size of the groups.
struct ShiftedViews {
  std::vector<ShiftBlock> blocks;
  std::size_t group_chunks = 0;
  std::size_t most_compared = 0;  ///< largest number of bytes that a shift compares
};

/// For each template of `group_count` groups, the smallest SAD over all shifts.
/// @param groups aligned to 64 bytes. @param smallest 8 values per group.
using SmallestSads = void (*)(const std::uint8_t* groups, std::size_t group_count, const ShiftedViews& views,
                              std::uint32_t* smallest);

/// @throws std::invalid_argument if this processor lacks the level.
SmallestSads smallestSadsFor(SimdLevel level);

}  // namespace ratslam
