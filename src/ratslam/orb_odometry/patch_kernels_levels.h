/// One table of patch kernels per instruction set.
#pragma once

#include <cstring>

#include "ratslam/orb_odometry/patch_kernels.h"

namespace ratslam {

const PatchKernels& patchKernelsPortable();
#if defined(__x86_64__)
const PatchKernels& patchKernelsAvx2();
#endif

}  // namespace ratslam
