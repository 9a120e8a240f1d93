#include "patch_kernels_levels.h"

#if defined(__x86_64__)
#pragma GCC push_options
#pragma GCC target("avx2")

namespace ratslam {
namespace {
#include "patch_kernels_body.h"
}  // namespace

const PatchKernels& patchKernelsAvx2() { return kKernels; }

}  // namespace ratslam

#pragma GCC pop_options
#endif
