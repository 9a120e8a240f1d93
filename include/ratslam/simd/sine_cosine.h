/// Sine and cosine with the same bits everywhere: on every processor, at every instruction set, with every
/// C library, one angle at a time or many together.
///
/// Only additions, multiplications and operations on bits, each rounded as IEEE 754 says. An angle is reduced
/// to the nearest multiple of pi/2 with pi/2 in three parts (Cody & Waite, "Software Manual for the
/// Elementary Functions"), what is left to [-pi/4, pi/4] and a rounding error; there the Taylor series is
/// summed up to the 17th power, whose remainder is below 2^-60. The result is less than 0.8 units in the last
/// place from the true one. Angles beyond kLargestReducedAngle, infinite and undefined ones are left to the C
/// library.
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

/// Of `count` angles.
using SinesCosines = void (*)(const double* angles_rad, std::size_t count, double* sines, double* cosines);

/// @throws std::invalid_argument where this processor lacks the level.
SinesCosines sinesCosinesFor(SimdLevel level);

}  // namespace ratslam
