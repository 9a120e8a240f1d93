/// Sine and cosine with the same bits on every processor, at every instruction set, with every C library, for one angle or
/// many.
///
/// The functions use only additions, multiplications and operations on bits, rounded according to IEEE 754. Steps:
///  1. Reduce the angle by the nearest multiple of pi/2, with pi/2 in three parts (Cody & Waite, "Software Manual for
///     the Elementary Functions"). The rest is in [-pi/4, pi/4], with a rounding error that is kept.
///  2. Sum the Taylor series up to the 17th power. Its remainder is below 2^-60.
/// The error of the result is less than 0.8 units in the last place. Angles beyond kLargestReducedAngle, infinite and
/// undefined ones are passed to the C library.
#pragma once

#include <cstddef>

#include "ratslam/simd/simd_level.h"

namespace ratslam {

constexpr double kLargestReducedAngle = 1e6;  ///< [rad]

struct SineCosine {
  double sine = 0.0;
  double cosine = 1.0;
};

SineCosine sineCosine(double angle_rad);

/// Sines and cosines of `count` angles.
using SinesCosines = void (*)(const double* angles_rad, std::size_t count, double* sines, double* cosines);

/// @throws std::invalid_argument if this processor lacks the level.
SinesCosines sinesCosinesFor(SimdLevel level);

}  // namespace ratslam
