/// Arithmetic on the pixels of features, compiled for several instruction sets and chosen at run time. All of
/// it is in whole numbers: every level gives the same bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "ratslam/simd/simd_level.h"

namespace ratslam {

constexpr int kLeastRow = 32;    ///< shortest row that the kernels of whole rows take [px]
constexpr int kFastReach = 3;    ///< FAST looks this far around a pixel
constexpr int kSmoothReach = 3;  ///< so does the smoothing
constexpr int kDiscRadius = 15;  ///< of the intensity centroid [px], as in the ORB paper
constexpr int kBriefTests = 256;
constexpr int kBriefReach = 15;  ///< distance of the farthest test point from the corner [px]

/// First moments of the grey values in the disc around a pixel, x right and y down.
struct DiscMoments {
  int x = 0;
  int y = 0;
};

/// Test k compares point k with point kBriefTests + k.
struct BriefPattern {
  std::int16_t x[2 * kBriefTests];
  std::int16_t y[2 * kBriefTests];
};

struct FeatureKernels {
  /// FAST-9 scores (Rosten and Drummond 2006): the smallest threshold at which a pixel is no corner any more;
  /// 0 for those that are none at `threshold`. @param row first of `count` pixels; the circle around each is
  /// readable.
  void (*cornerScores)(const std::uint8_t* row, std::ptrdiff_t stride, int count, int threshold,
                       std::uint8_t* scores);

  /// Keeps the scores that are larger than all eight around them, and puts 0 elsewhere.
  /// @param scores three rows: above, this, below; readable from -1 to `count`.
  void (*localMaxima)(const std::uint8_t* const scores[3], int count, std::uint8_t* maxima);

  /// One row through a vertical Gaussian of 2 px deviation: rows[0..6] are the seven around it.
  void (*smoothColumns)(const std::uint8_t* const rows[7], int count, std::uint8_t* out);
  /// The same along the row, which is readable from -3 to `count` + 2.
  void (*smoothRow)(const std::uint8_t* row, int count, std::uint8_t* out);

  /// @param centre readable from -15 to +16 px along each row of the disc.
  DiscMoments (*discMoments)(const std::uint8_t* centre, std::ptrdiff_t stride);

  /// The tests of a pattern turned by the angle whose cosine and sine are given times 2^14: bit k is set
  /// where the first point of test k is darker. @param out 32 bytes, bit k in byte k / 8.
  void (*describe)(const std::uint8_t* centre, std::ptrdiff_t stride, const BriefPattern& pattern, int cosine,
                   int sine, std::uint8_t* out);

  /// Number of differing bits of two descriptors of 32 bytes.
  int (*hammingDistance)(const std::uint8_t* a, const std::uint8_t* b);
  /// Those of a descriptor to `count` others that lie one behind the other.
  void (*hammingDistances)(const std::uint8_t* one, const std::uint8_t* others, std::size_t count,
                           int* distances);
};

/// Those of AVX2 for AVX-512, too, and for every other level what all machines of the architecture have.
/// @throws std::invalid_argument where this processor lacks the level.
const FeatureKernels& featureKernels(SimdLevel level = bestSimdLevel());

}  // namespace ratslam
