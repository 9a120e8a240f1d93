#include "ratslam/orb_odometry/patch_kernels.h"

#include "patch_kernels_levels.h"

namespace ratslam {

#if defined(__x86_64__)

const PatchKernels& patchKernels(SimdLevel level) {
  if (level == SimdLevel::kAvx512 || level == SimdLevel::kAvx2) return patchKernelsAvx2();
  return patchKernelsPortable();
}

#else

const PatchKernels& patchKernels(SimdLevel) { return patchKernelsPortable(); }

#endif

}  // namespace ratslam
