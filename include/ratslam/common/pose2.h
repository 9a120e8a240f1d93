/// A pose in the plane, and its composition (SE(2)).
#pragma once

#include <cmath>

#include "ratslam/common/angles.h"

namespace ratslam {

struct Pose2 {
  double x = 0.0;   ///< [m]
  double y = 0.0;   ///< [m]
  double th = 0.0;  ///< facing [rad]
};

/// Composition: converts `b` from the frame of `a` to the frame in which `a` is given.
inline Pose2 compose(const Pose2& a, const Pose2& b) {
  const double c = std::cos(a.th);
  const double s = std::sin(a.th);
  return {a.x + c * b.x - s * b.y, a.y + s * b.x + c * b.y, wrapAngle(a.th + b.th)};
}

/// The pose of `b` in the frame of `a`: compose(a, between(a, b)) == b.
inline Pose2 between(const Pose2& a, const Pose2& b) {
  const double c = std::cos(a.th);
  const double s = std::sin(a.th);
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  return {c * dx + s * dy, -s * dx + c * dy, wrapAngle(b.th - a.th)};
}

}  // namespace ratslam
