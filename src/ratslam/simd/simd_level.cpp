#include "ratslam/simd/simd_level.h"

namespace ratslam {

std::vector<SimdLevel> availableSimdLevels() {
  std::vector<SimdLevel> levels{SimdLevel::kScalar};
#if defined(__x86_64__)
  levels.push_back(SimdLevel::kSse2);  // part of every x86-64
  if (__builtin_cpu_supports("avx2")) levels.push_back(SimdLevel::kAvx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw")) {
    levels.push_back(SimdLevel::kAvx512);
  }
#elif defined(__aarch64__)
  levels.push_back(SimdLevel::kNeon);  // part of every arm64
#endif
  return levels;
}

}  // namespace ratslam
