/// Occupied ground: upright boxes seen from above, and a fast test whether a new one would overlap them (separating axes).
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "town/mesh.h"

namespace ratslam {

/// A rectangle on the ground [m], given by its centre, its forward direction (length 1) and half its sides.
struct Footprint {
  double x, z, forward_x, forward_z, half_width, half_depth;
  /// The footprint of a box in a frame.
  static Footprint of(const UprightFrame& frame, const Extent& extent);
  bool overlaps(const Footprint& other) const;
};

class FootprintIndex {
 public:
  bool isFree(const Footprint& footprint) const;
  void add(const Footprint& footprint);

 private:
  template <class Visit>
  static void visitSquares(const Footprint& footprint, Visit&& visit);
  std::unordered_map<std::int64_t, std::vector<Footprint>> squares_;
};

}  // namespace ratslam
