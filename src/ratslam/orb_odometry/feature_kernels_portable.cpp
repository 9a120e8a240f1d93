#include "feature_kernels_levels.h"

#define RATSLAM_BYTE_LANES 16

namespace ratslam {
namespace {
#include "feature_kernels_body.h"
}  // namespace

const FeatureKernels& featureKernelsPortable() { return kKernels; }

}  // namespace ratslam
