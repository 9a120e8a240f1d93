#include "ratslam/pose_cells/gather.h"

#include <algorithm>

#include "ratslam/pose_cells/region.h"

namespace ratslam {

GatherAxis::GatherAxis(int begin, int n_outputs, int radius, int length, bool ring, int origin, int stored)
    : count(n_outputs), period(ring ? length : 0) {
  const int positions = n_outputs + 2 * radius;
  const int offset = begin - radius;  // source of position 0
  first = ring ? 0 : std::clamp(-offset, 0, positions);
  last = ring ? positions : std::clamp(length - offset, first, positions);
  sources.resize(static_cast<std::size_t>(positions), 0);
  for (int p = first; p < last; ++p) {
    const int source = ring ? wrapIndex(offset + p, length) : offset + p;
    sources[static_cast<std::size_t>(p)] = wrapIndex(origin + source, stored);
  }
}

}  // namespace ratslam
