#include "sine_cosine_levels.h"

#define RATSLAM_SIMD_LANES 2

namespace ratslam {
namespace {
#include "sine_cosine_body.h"
}  // namespace

void sinesCosinesPortable(const double* angles_rad, std::size_t count, double* sines, double* cosines) {
  sinesCosines(angles_rad, count, sines, cosines);
}

}  // namespace ratslam
