/// Sums of absolute differences (SAD) of bytes between one view and groups of 8 templates.
///
/// A group interleaves its templates in chunks: 8 bytes of the first template, the same 8 of the second, and so on,
/// 64 bytes in all. One instruction then compares the same part of several templates with the view, and each
/// template's sum stays in a lane of its own: nothing is added up across lanes.
///
/// To shift the view against the templates, the view is laid out once for each shift; the bytes of a template that
/// a shift does not compare are masked in the first and last chunk and left out elsewhere.
#pragma once

#include <cstddef>
#include <cstdint>

#include "ratslam/local_view/simd_level.h"

namespace ratslam {

constexpr std::size_t kGroupLanes = 8;   // templates in a group
constexpr std::size_t kChunkBytes = 64;  // 8 bytes of each

/// One chunk whose bytes are compared only where the mask is set.
struct MaskedChunk {
  std::size_t chunk = 0;
  std::uint64_t view = 0;
  std::uint64_t mask = 0;
};

/// The view at one shift: a masked chunk, a run of whole ones, a masked one.
struct ShiftedView {
  MaskedChunk head;
  MaskedChunk tail;
  const std::uint64_t* middle_view = nullptr;
  std::size_t middle_chunk = 0;
  std::size_t middle_count = 0;
};

/// The shifts of a view, and the size of what it is compared with.
struct ShiftedViews {
  const ShiftedView* shifts = nullptr;
  std::size_t shift_count = 0;
  std::size_t group_chunks = 0;
};

/// For each template of `group_count` groups, the smallest SAD over all shifts.
/// @param groups aligned to 64 bytes. @param smallest 8 values a group.
using SmallestSads = void (*)(const std::uint8_t* groups, std::size_t group_count, const ShiftedViews& views,
                              std::uint32_t* smallest);

/// @throws std::invalid_argument where this processor lacks the level.
SmallestSads smallestSadsFor(SimdLevel level);

}  // namespace ratslam
