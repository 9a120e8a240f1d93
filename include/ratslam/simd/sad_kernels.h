/// Sums of absolute differences (SAD) of bytes between one view and groups of 8 templates.
///
/// A group interleaves its templates in chunks: 8 bytes of the first template, the same 8 of the second, and
/// so on, 64 bytes in all. One instruction then compares the same part of several templates with the view,
/// and each template's sum stays in a lane of its own: nothing is added up across lanes.
///
/// To shift the view against the templates, the view is laid out once for each shift. Shifts go in blocks of
/// 4, so that a chunk is loaded once for all of them. The bytes of a template that a shift does not compare
/// are masked in the chunks at the block's two ends; in the chunks between them all shifts compare every
/// byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ratslam/simd/simd_level.h"

namespace ratslam {

constexpr std::size_t kGroupLanes = 8;   // templates in a group
constexpr std::size_t kChunkBytes = 64;  // 8 bytes of each

constexpr std::size_t kBlockShifts = 4;

/// The view at 4 shifts. Of the chunks [begin, end) those in [inner_begin, inner_end) need no mask.
struct ShiftBlock {
  std::size_t begin = 0;
  std::size_t inner_begin = 0;
  std::size_t inner_end = 0;
  std::size_t end = 0;
  std::vector<std::uint64_t>
      view;  ///< of chunk c at shift s: [c * kBlockShifts + s], 0 where nothing is compared
  std::vector<std::uint64_t> mask;  ///< likewise: the bytes compared
};

/// The shifts of a view, and the size of what it is compared with.
struct ShiftedViews {
  std::vector<ShiftBlock> blocks;
  std::size_t group_chunks = 0;
  std::size_t most_compared = 0;  ///< bytes, by any of the shifts
};

/// For each template of `group_count` groups, the smallest SAD over all shifts.
/// @param groups aligned to 64 bytes. @param smallest 8 values a group.
using SmallestSads = void (*)(const std::uint8_t* groups, std::size_t group_count, const ShiftedViews& views,
                              std::uint32_t* smallest);

/// @throws std::invalid_argument where this processor lacks the level.
SmallestSads smallestSadsFor(SimdLevel level);

}  // namespace ratslam
