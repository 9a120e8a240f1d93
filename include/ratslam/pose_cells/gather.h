/// Copying of cells between the torus and contiguous memory without its seams.
#pragma once

#include <cstddef>
#include <vector>

#include "ratslam/simd/row_kernels.h"

namespace ratslam {

/// Source cells along one axis of a convolution. Output p reads positions p to p + 2 radius. Positions in
/// [first, last) have a source; the others are 0.
struct GatherAxis {
  /// Plans `count` outputs from position `begin` on. The axis has `length` sources; it is a ring, or has zeros
  /// around. The sources are stored on a ring of `stored` cells from `origin` on.
  void set(int begin, int count, int radius, int length, bool ring, int origin, int stored);

  int source(int position) const { return sources[static_cast<std::size_t>(position)]; }
  int positions() const { return static_cast<int>(sources.size()); }

  int count = 0;   ///< outputs
  int period = 0;  ///< positions this far apart have the same source; 0: no two positions have
  int first = 0;
  int last = 0;
  std::vector<int> sources;  ///< stored index of each position
};

/// Plan for copying cells of the rows of a layer.
struct RowPlan {
  std::vector<RowSegment> segments;
  std::vector<std::ptrdiff_t> from;  ///< offset of each source row
  std::vector<std::ptrdiff_t> to;    ///< offset of each target row

  int rows() const { return static_cast<int>(from.size()); }
  int segmentCount() const { return static_cast<int>(segments.size()); }

  /// Plans the copy of all rows and cells that have a source to their positions.
  void planGathering(const GatherAxis& columns, const GatherAxis& rows, std::ptrdiff_t from_stride,
                     std::ptrdiff_t to_stride);

  /// Appends `count` cells of each row. Cell c is copied from column from_column(c) to column to_column(c).
  template <class From, class To>
  void appendColumns(int count, From from_column, To to_column) {
    for (int c = 0; c < count; ++c) {
      const bool goes_on =
          c > 0 && from_column(c) == from_column(c - 1) + 1 && to_column(c) == to_column(c - 1) + 1;
      if (!goes_on) segments.push_back({from_column(c), to_column(c), 0});
      ++segments.back().count;
    }
  }
  void appendRow(std::ptrdiff_t from_offset, std::ptrdiff_t to_offset) {
    from.push_back(from_offset);
    to.push_back(to_offset);
  }
  void clear() {
    segments.clear();
    from.clear();
    to.clear();
  }
};

}  // namespace ratslam
