#include "town/footprint.h"

#include <cmath>

namespace ratslam {
namespace {

constexpr double kSquare = 16.0;  // [m]

/// Half the length of a footprint's shadow on an axis.
double reach(const Footprint& f, double axis_x, double axis_z) {
  return f.half_depth * std::abs(f.forward_x * axis_x + f.forward_z * axis_z) +
         f.half_width * std::abs(f.forward_z * axis_x - f.forward_x * axis_z);
}

bool separatedAlong(const Footprint& a, const Footprint& b, double axis_x, double axis_z) {
  const double gap = std::abs((b.x - a.x) * axis_x + (b.z - a.z) * axis_z);
  return gap >= reach(a, axis_x, axis_z) + reach(b, axis_x, axis_z);
}

}  // namespace

Footprint Footprint::of(const UprightFrame& frame, const Extent& e) {
  const Eigen::Vector3f centre = frame.at(0.5 * (e.right0 + e.right1), 0.0, 0.5 * (e.forward0 + e.forward1));
  return {centre.x(),
          centre.z(),
          frame.forward_x,
          frame.forward_z,
          0.5 * (e.right1 - e.right0),
          0.5 * (e.forward1 - e.forward0)};
}

bool Footprint::overlaps(const Footprint& other) const {
  return !separatedAlong(*this, other, forward_x, forward_z) &&
         !separatedAlong(*this, other, forward_z, -forward_x) &&
         !separatedAlong(*this, other, other.forward_x, other.forward_z) &&
         !separatedAlong(*this, other, other.forward_z, -other.forward_x);
}

template <class Visit>
void FootprintIndex::visitSquares(const Footprint& f, Visit&& visit) {
  const double radius = std::hypot(f.half_width, f.half_depth);
  for (auto column = static_cast<std::int64_t>(std::floor((f.x - radius) / kSquare));
       column <= static_cast<std::int64_t>(std::floor((f.x + radius) / kSquare)); ++column)
    for (auto row = static_cast<std::int64_t>(std::floor((f.z - radius) / kSquare));
         row <= static_cast<std::int64_t>(std::floor((f.z + radius) / kSquare)); ++row)
      visit(column * (std::int64_t{1} << 32) + (row & 0xFFFFFFFF));
}

bool FootprintIndex::isFree(const Footprint& footprint) const {
  bool free = true;
  visitSquares(footprint, [&](std::int64_t key) {
    const auto square = squares_.find(key);
    if (square == squares_.end()) return;
    for (const Footprint& other : square->second) free = free && !footprint.overlaps(other);
  });
  return free;
}

void FootprintIndex::add(const Footprint& footprint) {
  visitSquares(footprint, [&](std::int64_t key) { squares_[key].push_back(footprint); });
}

}  // namespace ratslam
