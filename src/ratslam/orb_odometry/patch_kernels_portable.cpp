#include "patch_kernels_levels.h"

namespace ratslam {
namespace {
#include "patch_kernels_body.h"
}  // namespace

const PatchKernels& patchKernelsPortable() { return kKernels; }

}  // namespace ratslam
