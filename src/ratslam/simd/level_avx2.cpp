#include "levels.h"

#if defined(__x86_64__)
RATSLAM_BEGIN_TARGET("avx2,popcnt")

#define RATSLAM_REGISTER_BYTES 32
#define RATSLAM_LAMBDA RATSLAM_LAMBDA_TARGET("avx2,popcnt")

namespace ratslam {
namespace {
#include "level_body.h"
}  // namespace

Kernels kernelsAvx2() { return kernelsOfLevel(features::kFeatureKernels, smallestSadsAvx2, nullptr); }

}  // namespace ratslam

RATSLAM_END_TARGET
#endif
