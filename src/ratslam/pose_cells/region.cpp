#include "ratslam/pose_cells/region.h"

#include <algorithm>

namespace ratslam {
namespace {

bool isNear(const Span& a, const Span& b, int margin, int size) {
  return wrapIndex(b.begin - a.begin, size) < a.length + margin ||
         wrapIndex(a.begin - b.begin, size) < b.length + margin;
}

bool isNear(const Box& a, const Box& b, int margin, const RingSizes& sizes) {
  for (const std::size_t axis : {kColumn, kRow, kLayer})
    if (!isNear(a[axis], b[axis], margin, sizes[axis])) return false;
  return true;
}

/// Shortest span around two spans.
Span hull(const Span& a, const Span& b, int size) {
  const auto startingWith = [size](const Span& first, const Span& second) {
    const int length = std::max(first.length, wrapIndex(second.begin - first.begin, size) + second.length);
    return Span{first.begin, length};
  };
  const Span from_a = startingWith(a, b);
  const Span from_b = startingWith(b, a);
  const Span shorter = from_b.length < from_a.length ? from_b : from_a;
  return shorter.length >= size ? Span{0, size} : shorter;
}

}  // namespace

void mergeInto(std::vector<Box>& boxes, Box box, const RingSizes& sizes, int margin) {
  for (std::size_t b = 0; b < boxes.size();) {
    if (!isNear(box, boxes[b], margin, sizes)) {
      ++b;
      continue;
    }
    for (const std::size_t axis : {kColumn, kRow, kLayer})
      box[axis] = hull(box[axis], boxes[b][axis], sizes[axis]);
    boxes.erase(boxes.begin() + static_cast<std::ptrdiff_t>(b));
    b = 0;  // the larger box may be near boxes that were checked before
  }
  boxes.push_back(box);
}

std::vector<Box> coalesced(const std::vector<Box>& boxes, const RingSizes& sizes, int margin) {
  std::vector<Box> merged;
  for (const Box& box : boxes) mergeInto(merged, box, sizes, margin);
  return merged;
}

std::vector<Span> occupiedSpans(const double* values, int size, bool ring, int min_gap) {
  // On a ring, start after a gap, so that no run is divided.
  int start = 0;
  if (ring) {
    int empty = 0;
    bool found = false;
    for (int i = 0; i < 2 * size && !found; ++i) {
      if (values[i % size] > 0.0) {
        found = empty >= min_gap;
        if (found) start = i % size;
        empty = 0;
      } else {
        ++empty;
      }
    }
    if (!found) return {{0, size}};
  }
  std::vector<Span> spans;
  int last = 0;
  for (int i = 0; i < size; ++i) {
    const int position = (start + i) % size;
    if (!(values[position] > 0.0)) continue;
    if (spans.empty() || i - last > min_gap) {
      spans.push_back({position, 1});
    } else {
      spans.back().length += i - last;
    }
    last = i;
  }
  return spans;
}

}  // namespace ratslam
