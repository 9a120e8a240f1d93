#include "ratslam/orb_odometry/feature_kernels.h"

#include "feature_kernels_levels.h"

namespace ratslam {

#if defined(__x86_64__)

const FeatureKernels& featureKernels(SimdLevel level) {
  if (level == SimdLevel::kAvx512 || level == SimdLevel::kAvx2) return featureKernelsAvx2();
  return featureKernelsPortable();
}

#else

const FeatureKernels& featureKernels(SimdLevel) { return featureKernelsPortable(); }

#endif

}  // namespace ratslam
