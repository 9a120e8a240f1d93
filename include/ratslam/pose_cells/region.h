/// Boxes on the torus of pose cells, with which work is confined to where activity is.
#pragma once

#include <array>
#include <vector>

#include "ratslam/simd/row_kernels.h"

namespace ratslam {

/// `index` on a ring of `size` cells, in [0, size).
inline int wrapIndex(int index, int size) {
  if (index >= 0 && index < size) return index;
  const int rest = index % size;
  return rest < 0 ? rest + size : rest;
}

/// An arc of a ring of cells.
struct Span {
  int begin = 0;  ///< in [0, size of the ring)
  int length = 0;
};

enum Axis : std::size_t { kColumn = 0, kRow = 1, kLayer = 2 };

/// A box of cells: spans along columns, rows, layers.
using Box = std::array<Span, 3>;
/// Ring sizes along columns, rows, layers.
using RingSizes = std::array<int, 3>;

/// Adds a box to a list, merged with those that have fewer than `margin` free cells between them and it along
/// every axis (margin 0: that overlap it), as the box around them, until there are none.
void mergeInto(std::vector<Box>& boxes, Box box, const RingSizes& sizes, int margin);

/// The boxes, merged until all are apart by `margin`.
std::vector<Box> coalesced(const std::vector<Box>& boxes, const RingSizes& sizes, int margin);

/// The runs of positive values, parted where `min_gap` or more are not. On a ring that has no such gap the
/// one span is the whole ring, and a run may pass its end.
std::vector<Span> occupiedSpans(const double* values, int size, bool ring, int min_gap);

}  // namespace ratslam
