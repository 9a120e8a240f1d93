#include "levels.h"

#if defined(__x86_64__)
RATSLAM_BEGIN_TARGET("avx512f,avx512bw")

#define RATSLAM_REGISTER_BYTES 64
#define RATSLAM_LAMBDA RATSLAM_LAMBDA_TARGET("avx512f,avx512bw")
#define RATSLAM_FEATURES_OF_NARROWER_LEVEL  // wider registers are no faster for them

namespace ratslam {
namespace {
#include "level_body.h"
}  // namespace

Kernels kernelsAvx512() {
  return kernelsOfLevel(*kernelsAvx2().features, smallestSadsAvx512, slidingSadsAvx512);
}

}  // namespace ratslam

RATSLAM_END_TARGET
#endif
