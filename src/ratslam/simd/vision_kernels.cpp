#include "vision_kernels_levels.h"

namespace ratslam {
namespace {

OrbKernels orbKernels(SimdLevel level) {
#if defined(__x86_64__)
  if (level == SimdLevel::kAvx512) return orbKernelsAvx512();
  if (level == SimdLevel::kAvx2) return orbKernelsAvx2();
#else
  static_cast<void>(level);
#endif
  return orbKernelsPortable();
}

}  // namespace

const FeatureKernels& featureKernels(SimdLevel level) { return orbKernels(level).features; }

const PatchKernels& patchKernels(SimdLevel level) { return orbKernels(level).patches; }

const SchurKernels& schurKernels(SimdLevel level) { return orbKernels(level).schur; }

}  // namespace ratslam
