/// How cells of the torus are brought together in memory without its seams, and back.
#pragma once

#include <vector>

#include "ratslam/pose_cells/simd.h"

namespace ratslam {

/// Where the cells come from that one axis of a convolution reads: output position p reads positions p to
/// p + 2 radius, of which those in [first, last) have a source and the others are 0.
struct GatherAxis {
  /// The `count` outputs from position `begin` on, of an axis with `length` sources, a ring or with zeros
  /// around. Sources are stored on a ring of `stored` cells from `origin` on.
  GatherAxis(int begin, int count, int radius, int length, bool ring, int origin, int stored);

  int source(int position) const { return sources[static_cast<std::size_t>(position)]; }

  int count = 0;   ///< outputs
  int period = 0;  ///< positions this far apart have the same source; 0: none have
  int first = 0;
  int last = 0;
  std::vector<int> sources;  ///< stored index of each position
};

/// Appends the unbroken stretches of `count` cells, cell c being moved from column from(c) to column to(c).
template <class From, class To>
void appendSegments(std::vector<RowSegment>& segments, int count, From from, To to) {
  for (int c = 0; c < count; ++c) {
    const bool goes_on = c > 0 && from(c) == from(c - 1) + 1 && to(c) == to(c - 1) + 1;
    if (!goes_on) segments.push_back({from(c), to(c), 0});
    ++segments.back().count;
  }
}

}  // namespace ratslam
