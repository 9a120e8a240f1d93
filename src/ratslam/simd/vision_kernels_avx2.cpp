#include "vision_kernels_levels.h"

#if defined(__x86_64__)
#pragma GCC push_options
#pragma GCC target("avx2,popcnt")

#define RATSLAM_REGISTER_BYTES 32

namespace ratslam {
namespace {
#include "feature_kernels_body.h"
#include "patch_kernels_body.h"
#include "schur_kernels_body.h"
}  // namespace

OrbKernels orbKernelsAvx2() { return {kFeatureKernels, kPatchKernels, kSchurKernels}; }

}  // namespace ratslam

#pragma GCC pop_options
#endif
