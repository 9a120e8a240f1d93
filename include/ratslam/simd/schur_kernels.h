/// The inner loop of bundle adjustment, compiled for several instruction sets and chosen at run time: points
/// leave the normal equations (Schur complement), and what they knew goes to the poses that saw them.
/// Products are not fused: every level gives the same bits.
#pragma once

#include "ratslam/simd/simd_level.h"

namespace ratslam {

/// Six rows of a pose's equations and two zeros, so that a column fills whole registers.
constexpr int kSchurRows = 8;

/// A block of two poses' equations, column by column; the gradient counts on the diagonal only.
struct PoseEquations {
  double hessian[6][kSchurRows] = {};
  double gradient[kSchurRows] = {};
};

/// A free pose's view of a point.
struct FreeView {
  int pose = 0;
  double coupling[3][kSchurRows] = {};  ///< of pose (rows) and point (columns), column by column
};

struct PointEquations {
  double inverse[3][3];  ///< of the point's own Hessian
  double gradient[3];
};

struct SchurKernels {
  /// Subtracts coupling_a * inverse * coupling_b^T from block (a, b) for all views a, b of one point with
  /// pose b <= pose a, and coupling_a * inverse * gradient from the gradient of a.
  /// @param poses number of free poses. @param equations poses x poses blocks, row by row.
  void (*eliminatePoint)(const FreeView* views, int count, const PointEquations& point, int poses,
                         PoseEquations* equations);
};

/// Those of AVX-512 or AVX2, and for every other level what all machines of the architecture have.
/// @throws std::invalid_argument where this processor lacks the level.
const SchurKernels& schurKernels(SimdLevel level = bestSimdLevel());

}  // namespace ratslam
