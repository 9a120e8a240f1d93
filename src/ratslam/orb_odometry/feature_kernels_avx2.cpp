#include "feature_kernels_levels.h"

#if defined(__x86_64__)
#pragma GCC push_options
#pragma GCC target("avx2,popcnt")

#define RATSLAM_BYTE_LANES 32

namespace ratslam {
namespace {
#include "feature_kernels_body.h"
}  // namespace

const FeatureKernels& featureKernelsAvx2() { return kKernels; }

}  // namespace ratslam

#pragma GCC pop_options
#endif
