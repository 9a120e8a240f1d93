/// Sums of absolute differences (SAD) of bytes for shifts one column apart, twice as fast as the general
/// kernels: AVX-512's dbsad instruction slides 4 bytes of the view along 8 bytes of a template, one column a
/// step, and so compares 4 shifts at once.
///
/// Groups of 8 templates are interleaved in chunks as in sad_kernels.h, but a template's bytes go row by row,
/// in quads of 4 columns, two in a chunk; a row begins with the quad after the last row's. Where the compared
/// columns are no multiple of 4, the view is filled up with black columns. These add to the sum what the
/// template has opposite them, which may be the next row's beginning; how much that is at each shift is kept
/// in the group, and subtracted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "ratslam/simd/simd_level.h"

namespace ratslam {

/// The shape of templates and shifts.
struct SlidingShape {
  SlidingShape() = default;
  SlidingShape(std::size_t columns, std::size_t rows, std::size_t shifts);

  /// Whether the kernel's integers are wide enough.
  bool isSupported() const;

  /// Where a group has a byte of its first template.
  std::size_t placeOf(std::size_t column, std::size_t row) const {
    const std::size_t quad = row * row_quads + column / 4;
    return quad / 2 * 64 + quad % 2 * 4 + column % 4;
  }

  std::size_t rows = 0;
  std::size_t shift_count = 0;
  std::size_t compared = 0;      ///< columns
  std::size_t quads = 0;         ///< of 4 columns each, which hold the compared ones
  std::size_t row_quads = 0;     ///< that hold all columns
  std::size_t excess_chunk = 0;  ///< first of the chunks of 16-bit numbers to subtract: 4 shifts in each
  std::size_t group_chunks = 0;
  std::size_t fetched_chunks = 0;  ///< of a later group with each row
};

/// View and template at one shift, as far as filled up columns go: what to subtract from their SAD.
/// @param bytes of one template, column by column.
std::uint16_t slidingExcess(const SlidingShape& shape, const std::vector<std::uint8_t>& bytes,
                            std::size_t shift);

/// For each template of `group_count` groups, the smallest SAD over the shifts.
/// @param groups aligned to 64 bytes. @param view quads x 4 columns of each row, row by row.
/// @param smallest 8 values a group.
using SlidingSads = void (*)(const std::uint8_t* groups, std::size_t group_count, const SlidingShape& shape,
                             const std::vector<std::uint32_t>& view, std::uint32_t* smallest);

/// Null for levels that have no such instruction: the general kernels are their form of it.
/// @throws std::invalid_argument where this processor lacks the level.
SlidingSads slidingSadsFor(SimdLevel level);

}  // namespace ratslam
