#include "vision_kernels_levels.h"

#define RATSLAM_REGISTER_BYTES 16

namespace ratslam {
namespace {
#include "feature_kernels_body.h"
#include "patch_kernels_body.h"
#include "schur_kernels_body.h"
}  // namespace

OrbKernels orbKernelsPortable() { return {kFeatureKernels, kPatchKernels, kSchurKernels}; }

}  // namespace ratslam
