/// One table of feature kernels per instruction set.
#pragma once

#include <cstring>

#include "ratslam/orb_odometry/feature_kernels.h"

namespace ratslam {

const FeatureKernels& featureKernelsPortable();
#if defined(__x86_64__)
const FeatureKernels& featureKernelsAvx2();
#endif

}  // namespace ratslam
