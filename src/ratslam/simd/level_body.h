/// All kernels, for whichever instruction set the including source has chosen: inside an unnamed namespace of its
/// own target it defines RATSLAM_REGISTER_BYTES, the bytes in a register, and RATSLAM_LAMBDA, the mark of lambdas.

namespace patches {
#include "patch_kernels_body.h"
}
namespace schur {
#include "schur_kernels_body.h"
}
namespace rows {
#include "row_kernels_body.h"
}
namespace sine_cosine {
#include "sine_cosine_body.h"
}
#if !defined(RATSLAM_FEATURES_OF_NARROWER_LEVEL)
namespace features {
#include "feature_kernels_body.h"
}
#endif

Kernels kernelsOfLevel(const FeatureKernels& feature_kernels, SmallestSads smallest_sads,
                       SlidingSads sliding_sads) {
  return {&feature_kernels,          &patches::kPatchKernels, &schur::kSchurKernels, &rows::kKernels,
          sine_cosine::sinesCosines, smallest_sads,           sliding_sads};
}
