#include "row_kernels_levels.h"

#define RATSLAM_SIMD_LANES 2

namespace ratslam {
namespace {
#include "row_kernels_body.h"
}  // namespace

const RowKernels& rowKernelsPortable() { return kKernels; }

}  // namespace ratslam
