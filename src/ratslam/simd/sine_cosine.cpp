#include "ratslam/simd/sine_cosine.h"

#include "sine_cosine_levels.h"

namespace ratslam {

SineCosine sineCosine(double angle_rad) {
  SineCosine result;
  sinesCosinesPortable(&angle_rad, 1, &result.sine, &result.cosine);
  return result;
}

#if defined(__x86_64__)

SinesCosines sinesCosinesFor(SimdLevel level) {
  if (level == SimdLevel::kAvx512) return sinesCosinesAvx512;
  if (level == SimdLevel::kAvx2) return sinesCosinesAvx2;
  return sinesCosinesPortable;
}

#else

SinesCosines sinesCosinesFor(SimdLevel) { return sinesCosinesPortable; }

#endif

}  // namespace ratslam
