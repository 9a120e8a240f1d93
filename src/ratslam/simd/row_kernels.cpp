#include "ratslam/simd/row_kernels.h"

#include "row_kernels_levels.h"

namespace ratslam {

#if defined(__x86_64__)

const RowKernels& rowKernels(SimdLevel level) {
  if (level == SimdLevel::kAvx512) return rowKernelsAvx512();
  if (level == SimdLevel::kAvx2) return rowKernelsAvx2();
  return rowKernelsPortable();
}

#else

const RowKernels& rowKernels(SimdLevel) { return rowKernelsPortable(); }

#endif

}  // namespace ratslam
