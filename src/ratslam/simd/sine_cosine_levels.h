/// Sines and cosines of many angles, a function per instruction set.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "ratslam/simd/sine_cosine.h"

namespace ratslam {

void sinesCosinesPortable(const double* angles_rad, std::size_t count, double* sines, double* cosines);
#if defined(__x86_64__)
void sinesCosinesAvx2(const double* angles_rad, std::size_t count, double* sines, double* cosines);
void sinesCosinesAvx512(const double* angles_rad, std::size_t count, double* sines, double* cosines);
#endif

}  // namespace ratslam
