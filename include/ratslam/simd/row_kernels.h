/// Arithmetic on rows of pose cells. It is compiled for several instruction sets, one of which is selected at run time.
///
/// Every level gives the same bits: a vector holds only independent cells, multiplication and addition are not fused,
/// and a sum over cells always has eight partial sums (column modulo 8), for any width of a register. Widths are
/// multiples of kRowQuantum; rows are padded to that.
#pragma once

#include <cstddef>

#include "ratslam/simd/simd_level.h"

namespace ratslam {

constexpr int kRowQuantum = 8;  ///< cells; the widest register holds as many doubles

constexpr int paddedWidth(int width) { return (width + kRowQuantum - 1) / kRowQuantum * kRowQuantum; }

/// `count` cells of a row, from column `from` of one row to column `to` of another.
struct RowSegment {
  int from = 0;
  int to = 0;
  int count = 0;
};

/// Rows picked out of a volume: row r starts at data[offsets[r]].
template <class Cell>
struct RowSet {
  Cell* data = nullptr;
  const std::ptrdiff_t* offsets = nullptr;
};

/// Largest values of this layer and of those before it, by column (padded) and by row. Each row has kRowQuantum values,
/// one for each remainder of the column.
struct Maxima {
  double* columns = nullptr;
  double* rows = nullptr;
};

struct RowKernels {
  /// Copies the segments of `rows` rows.
  void (*copy)(RowSet<const double> in, RowSet<double> out, int rows, const RowSegment* segments,
               int n_segments);

  /// Weighted sum of a cell (weights[0]) and the cell at distance `other` (weights[1]), for the segments of `rows` rows.
  using Blend = void (*)(RowSet<const double> in, std::ptrdiff_t other, const double* weights,
                         RowSet<double> out, int rows, const RowSegment* segments, int n_segments);
  Blend blend;
  Blend addBlend;  ///< adds the sum to the output

  /// out[r][x] = sum over t = -radius..radius of weights[|t|] taps[t + radius][r][x].
  void (*convolve)(const double* const* taps, std::ptrdiff_t in_stride, double* out,
                   std::ptrdiff_t out_stride, int rows, std::ptrdiff_t width, const double* weights,
                   int radius);

  /// out[x] = sum over t = 0..taps-1 of weights[t] in[x + t tap].
  void (*correlate)(const double* in, std::ptrdiff_t tap, double* out, std::ptrdiff_t width,
                    const double* weights, int taps);

  /// Updates `maxima` with a layer. @return its largest value, at least 0.
  double (*findMaxima)(const double* in, int rows, int width, Maxima maxima);

  /// cells <- max(0, excited - cells - global) in the columns of `keep` (all bits set or none, per column), else 0.
  /// Adds the result to `sums` (kRowQuantum of them), and updates `maxima`. @return its largest value.
  double (*inhibit)(const double* excited, std::ptrdiff_t excited_stride, double* cells, int rows, int width,
                    double global, const long long* keep, double* sums, Maxima maxima);

  /// Largest of `count` > 0 values.
  double (*maximum)(const double* in, std::ptrdiff_t count);
};

/// The kernels of a level: those of AVX-512 or AVX2, and for all other levels those of the basic instruction set.
/// @throws std::invalid_argument if this processor lacks the level.
const RowKernels& rowKernels(SimdLevel level);

}  // namespace ratslam
