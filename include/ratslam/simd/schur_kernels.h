/// The inner loop of bundle adjustment: elimination of points from the normal equations (Schur complement). It is compiled
/// for several instruction sets, one of which is selected at run time. Products are not fused, so every level gives the
/// same bits.
#pragma once

#include "ratslam/simd/simd_level.h"

namespace ratslam {

/// Six rows of a pose's equations and two rows of zeros, so that a column fills whole registers.
constexpr int kSchurRows = 8;

/// A block of two poses' equations, column by column. The gradient is used on the diagonal only.
struct PoseEquations {
  double hessian[6][kSchurRows] = {};
  double gradient[kSchurRows] = {};
};

/// Observation of a point from a free pose.
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

/// The kernels of a level: those of AVX-512 or AVX2, and for all other levels those of the basic instruction set.
/// @throws std::invalid_argument if this processor lacks the level.
const SchurKernels& schurKernels(SimdLevel level = bestSimdLevel());

}  // namespace ratslam
