#include "simd_levels.h"

#define RATSLAM_SIMD_LANES 2

namespace ratslam {
namespace {
#include "row_kernels.h"
}  // namespace

const RowKernels& rowKernelsPortable() { return kKernels; }

}  // namespace ratslam
