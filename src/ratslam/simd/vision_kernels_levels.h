/// The tables of kernels, one of each kind per instruction set.
#pragma once

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <cstring>

#include "ratslam/simd/feature_kernels.h"
#include "ratslam/simd/patch_kernels.h"
#include "ratslam/simd/schur_kernels.h"

namespace ratslam {

struct OrbKernels {
  const FeatureKernels& features;
  const PatchKernels& patches;
  const SchurKernels& schur;
};

OrbKernels orbKernelsPortable();
#if defined(__x86_64__)
OrbKernels orbKernelsAvx2();
OrbKernels orbKernelsAvx512();
#endif

}  // namespace ratslam
