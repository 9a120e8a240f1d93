/// Instruction sets that vectorised code chooses from at run time. All of them give the same results.
#pragma once

#include <vector>

namespace ratslam {

enum class SimdLevel { kScalar, kSse2, kAvx2, kAvx512, kNeon };

/// What this processor can run, slowest first; kScalar always.
std::vector<SimdLevel> availableSimdLevels();

/// The fastest level that this processor can run.
inline SimdLevel bestSimdLevel() { return availableSimdLevels().back(); }

}  // namespace ratslam
