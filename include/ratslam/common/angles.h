/// Angles [rad], counter-clockwise positive (REP-103).
#pragma once

#include <cmath>

namespace ratslam {

constexpr double kPi = 3.14159265358979323846;

/// Wraps an angle to (-pi, pi].
inline double wrapAngle(double angle) {
  if (angle > -kPi && angle <= kPi) return angle;
  // Within one more turn this difference is exact, so that it equals the result of the division.
  if (std::abs(angle) < 9.0) return angle > 0.0 ? angle - 2.0 * kPi : angle + 2.0 * kPi;
  const double wrapped = std::remainder(angle, 2.0 * kPi);
  return wrapped <= -kPi ? wrapped + 2.0 * kPi : wrapped;
}

constexpr double degreesToRadians(double degrees) { return degrees * kPi / 180.0; }
constexpr double radiansToDegrees(double radians) { return radians * 180.0 / kPi; }

}  // namespace ratslam
