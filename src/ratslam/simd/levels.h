/// A table of all kernels for each instruction set, the selection among them, and the macros that compile a part of a
/// source for another instruction set than the rest of the program.
///
/// The kernels' bodies (*_body.h) are compiled once per level. The linker must not share any function of a level with the
/// rest of the program, because an old processor could then execute it. So bodies are in unnamed namespaces, after all
/// standard headers, and functions that are not inlined have no vectors as arguments.
#pragma once

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "ratslam/simd/feature_kernels.h"
#include "ratslam/simd/patch_kernels.h"
#include "ratslam/simd/row_kernels.h"
#include "ratslam/simd/sad_kernels.h"
#include "ratslam/simd/schur_kernels.h"
#include "ratslam/simd/sine_cosine.h"
#include "ratslam/simd/sliding_sad.h"

#define RATSLAM_PRAGMA(text) _Pragma(#text)
#if defined(__clang__)
// Clang ignores GCC's pragma. Its own does not apply to lambdas, so each of them needs a macro.
#define RATSLAM_BEGIN_TARGET(features) \
  RATSLAM_PRAGMA(clang attribute push(__attribute__((target(features))), apply_to = function))
#define RATSLAM_END_TARGET RATSLAM_PRAGMA(clang attribute pop)
#define RATSLAM_LAMBDA_TARGET(features) __attribute__((target(features)))
#else
#define RATSLAM_BEGIN_TARGET(features) RATSLAM_PRAGMA(GCC push_options) RATSLAM_PRAGMA(GCC target(features))
#define RATSLAM_END_TARGET RATSLAM_PRAGMA(GCC pop_options)
#define RATSLAM_LAMBDA_TARGET(features)
#endif

namespace ratslam {

struct Kernels {
  const FeatureKernels* features;
  const PatchKernels* patches;
  const SchurKernels* schur;
  const RowKernels* rows;
  SinesCosines sines_cosines;
  SmallestSads smallest_sads;
  SlidingSads sliding_sads;  ///< null if smallest_sads is as fast
};

/// The kernels of the basic instruction set, and the same with sums of absolute differences in plain C++.
Kernels kernelsOfArchitecture();
Kernels kernelsScalar();
#if defined(__x86_64__)
Kernels kernelsAvx2();
Kernels kernelsAvx512();
#endif

// The sums of absolute differences have their own code for each instruction set.
void smallestSadsScalar(const std::uint8_t* groups, std::size_t group_count, const ShiftedViews& views,
                        std::uint32_t* smallest);
void smallestSadsOfArchitecture(const std::uint8_t* groups, std::size_t group_count,
                                const ShiftedViews& views, std::uint32_t* smallest);
#if defined(__x86_64__)
void smallestSadsAvx2(const std::uint8_t* groups, std::size_t group_count, const ShiftedViews& views,
                      std::uint32_t* smallest);
void smallestSadsAvx512(const std::uint8_t* groups, std::size_t group_count, const ShiftedViews& views,
                        std::uint32_t* smallest);
void slidingSadsAvx512(const std::uint8_t* groups, std::size_t group_count, const SlidingShape& shape,
                       const std::vector<std::uint32_t>& view, std::uint32_t* smallest);
#endif

/// @throws std::invalid_argument if this processor lacks the level.
Kernels kernelsOf(SimdLevel level);

}  // namespace ratslam
