#include "ratslam/pose_cells/simd.h"

#include "simd_levels.h"

namespace ratslam {

#if defined(__x86_64__)

SimdLevel bestSimdLevel() {
  if (__builtin_cpu_supports("avx512f")) return SimdLevel::kAvx512;
  if (__builtin_cpu_supports("avx2")) return SimdLevel::kAvx2;
  return SimdLevel::kPortable;
}

const RowKernels& rowKernels(SimdLevel level) {
  if (level == SimdLevel::kAvx512) return rowKernelsAvx512();
  if (level == SimdLevel::kAvx2) return rowKernelsAvx2();
  return rowKernelsPortable();
}

#else

SimdLevel bestSimdLevel() { return SimdLevel::kPortable; }
const RowKernels& rowKernels(SimdLevel) { return rowKernelsPortable(); }

#endif

}  // namespace ratslam
