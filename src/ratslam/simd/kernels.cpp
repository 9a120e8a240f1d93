#include <stdexcept>
#include <vector>

#include "levels.h"

namespace ratslam {

Kernels kernelsOf(SimdLevel level) {
  const std::vector<SimdLevel> levels = availableSimdLevels();
  if (std::find(levels.begin(), levels.end(), level) == levels.end()) {
    throw std::invalid_argument("this processor lacks the requested instruction set");
  }
  if (level == SimdLevel::kScalar) return kernelsScalar();
#if defined(__x86_64__)
  if (level == SimdLevel::kAvx512) return kernelsAvx512();
  if (level == SimdLevel::kAvx2) return kernelsAvx2();
#endif
  return kernelsOfArchitecture();
}

const FeatureKernels& featureKernels(SimdLevel level) { return *kernelsOf(level).features; }
const PatchKernels& patchKernels(SimdLevel level) { return *kernelsOf(level).patches; }
const SchurKernels& schurKernels(SimdLevel level) { return *kernelsOf(level).schur; }
const RowKernels& rowKernels(SimdLevel level) { return *kernelsOf(level).rows; }
SinesCosines sinesCosinesFor(SimdLevel level) { return kernelsOf(level).sines_cosines; }
SmallestSads smallestSadsFor(SimdLevel level) { return kernelsOf(level).smallest_sads; }
SlidingSads slidingSadsFor(SimdLevel level) { return kernelsOf(level).sliding_sads; }

SineCosine sineCosine(double angle_rad) {
  SineCosine result;
  kernelsScalar().sines_cosines(&angle_rad, 1, &result.sine, &result.cosine);
  return result;
}

}  // namespace ratslam
