/// Instruction sets of the vectorised code, selected at run time. All of them give the same results.
#pragma once

#include <vector>

namespace ratslam {

enum class SimdLevel { kScalar, kSse2, kAvx2, kAvx512, kNeon };

/// The levels of this processor, slowest first; always with kScalar.
std::vector<SimdLevel> availableSimdLevels();

/// The fastest level of this processor.
inline SimdLevel bestSimdLevel() { return availableSimdLevels().back(); }

}  // namespace ratslam
