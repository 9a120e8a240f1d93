#include "row_kernels_levels.h"

#if defined(__x86_64__)
#pragma GCC push_options
#pragma GCC target("avx512f")

#define RATSLAM_SIMD_LANES 8

namespace ratslam {
namespace {
#include "row_kernels_body.h"
}  // namespace

const RowKernels& rowKernelsAvx512() { return kKernels; }

}  // namespace ratslam

#pragma GCC pop_options
#endif
