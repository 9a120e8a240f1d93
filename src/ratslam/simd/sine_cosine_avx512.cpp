#include "sine_cosine_levels.h"

#if defined(__x86_64__)
#pragma GCC push_options
#pragma GCC target("avx512f")

#define RATSLAM_SIMD_LANES 8

namespace ratslam {
namespace {
#include "sine_cosine_body.h"
}  // namespace

void sinesCosinesAvx512(const double* angles_rad, std::size_t count, double* sines, double* cosines) {
  sinesCosines(angles_rad, count, sines, cosines);
}

}  // namespace ratslam

#pragma GCC pop_options
#endif
