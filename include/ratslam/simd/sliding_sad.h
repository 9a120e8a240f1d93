/// Sums of absolute differences (SAD) of bytes for shifts one column apart, twice as fast as the general kernels. The
/// AVX-512 instruction dbsad slides 4 bytes of the view along 8 bytes of a template, by one column per step: so it
/// compares 4 shifts at once.
///
/// Groups of 8 templates are interleaved in chunks as in sad_kernels.h. But the bytes of a template are in row order, in
/// quads of 4 columns, two in a chunk. A row begins with the quad after the last one of the row before. If the number of
/// compared columns is no multiple of 4, the view is padded with black columns. Their SAD is the sum of the template's
/// values opposite them, which may belong to the next row. The group stores these sums for each shift, and they are
/// subtracted.
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

  /// Position in a group of a byte of its first template.
  std::size_t placeOf(std::size_t column, std::size_t row) const {
    const std::size_t quad = row * row_quads + column / 4;
    return quad / 2 * 64 + quad % 2 * 4 + column % 4;
  }

  std::size_t rows = 0;
  std::size_t shift_count = 0;
  std::size_t compared = 0;      ///< number of compared columns
  std::size_t quads = 0;         ///< number of quads for the compared columns
  std::size_t row_quads = 0;     ///< number of quads for all columns
  std::size_t excess_chunk = 0;  ///< first chunk of the 16-bit numbers to subtract; each has 4 shifts
  std::size_t group_chunks = 0;
  std::size_t fetched_chunks = 0;  ///< chunks of a later group that are prefetched with each row
};

/// SAD of the padding columns at one shift, which is to be subtracted.
/// @param bytes of one template, column by column.
std::uint16_t slidingExcess(const SlidingShape& shape, const std::vector<std::uint8_t>& bytes,
                            std::size_t shift);

/// For each template of `group_count` groups, the smallest SAD over the shifts.
/// @param groups aligned to 64 bytes. @param view quads x 4 columns of each row, row by row.
/// @param smallest 8 values per group.
using SlidingSads = void (*)(const std::uint8_t* groups, std::size_t group_count, const SlidingShape& shape,
                             const std::vector<std::uint32_t>& view, std::uint32_t* smallest);

/// Null for levels without such an instruction, which use the general kernels.
/// @throws std::invalid_argument if this processor lacks the level.
SlidingSads slidingSadsFor(SimdLevel level);

}  // namespace ratslam
