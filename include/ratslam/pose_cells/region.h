/// Boxes on the torus of pose cells. They confine the work to the cells with activity.
#pragma once

#include <array>
#include <vector>

#include "ratslam/simd/row_kernels.h"

namespace ratslam {

/// Wraps `index` on a ring of `size` cells to [0, size).
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

/// Adds a box to a list. As long as the list has a box with fewer than `margin` free cells to it along every axis
/// (margin 0: a box that overlaps it), the two are merged into the box around them.
void mergeInto(std::vector<Box>& boxes, Box box, const RingSizes& sizes, int margin);

/// Merges the boxes until all are `margin` cells apart.
std::vector<Box> coalesced(const std::vector<Box>& boxes, const RingSizes& sizes, int margin);

/// The runs of positive values. A gap shorter than `min_gap` does not divide a run. On a ring a run may pass the
/// end; a ring without a wide enough gap is one span.
std::vector<Span> occupiedSpans(const double* values, int size, bool ring, int min_gap);

}  // namespace ratslam
