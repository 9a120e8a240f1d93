/// One table of row kernels per instruction set.
#pragma once

#include "ratslam/simd/row_kernels.h"

namespace ratslam {

const RowKernels& rowKernelsPortable();
#if defined(__x86_64__)
const RowKernels& rowKernelsAvx2();
const RowKernels& rowKernelsAvx512();
#endif

}  // namespace ratslam
