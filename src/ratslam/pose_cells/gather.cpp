#include "ratslam/pose_cells/gather.h"

#include <algorithm>

#include "ratslam/pose_cells/region.h"

namespace ratslam {

void GatherAxis::set(int begin, int n_outputs, int radius, int length, bool ring, int origin, int stored) {
  count = n_outputs;
  period = ring ? length : 0;
  const int n_positions = n_outputs + 2 * radius;
  const int offset = begin - radius;  // source of position 0
  first = ring ? 0 : std::clamp(-offset, 0, n_positions);
  last = ring ? n_positions : std::clamp(length - offset, first, n_positions);
  sources.resize(static_cast<std::size_t>(n_positions));
  for (int p = first; p < last; ++p) {
    const int source = ring ? wrapIndex(offset + p, length) : offset + p;
    sources[static_cast<std::size_t>(p)] = wrapIndex(origin + source, stored);
  }
}

void RowPlan::planGathering(const GatherAxis& columns, const GatherAxis& rows, std::ptrdiff_t from_stride,
                            std::ptrdiff_t to_stride) {
  clear();
  appendColumns(
      columns.last - columns.first, [&](int c) { return columns.source(columns.first + c); },
      [&](int c) { return columns.first + c; });
  for (int p = rows.first; p < rows.last; ++p) appendRow(rows.source(p) * from_stride, p * to_stride);
}

}  // namespace ratslam
