#include "vision_kernels_levels.h"

#if defined(__x86_64__)
#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw")

#define RATSLAM_REGISTER_BYTES 64

namespace ratslam {
namespace {
#include "patch_kernels_body.h"
#include "schur_kernels_body.h"
}  // namespace

// Features were no faster with wider registers.
OrbKernels orbKernelsAvx512() { return {orbKernelsAvx2().features, kPatchKernels, kSchurKernels}; }

}  // namespace ratslam

#pragma GCC pop_options
#endif
