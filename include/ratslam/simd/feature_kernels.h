/// Arithmetic on the pixels of features. It is compiled for several instruction sets, one of which is selected at run
/// time. All numbers are whole, so every level gives the same bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "ratslam/simd/simd_level.h"

namespace ratslam {

constexpr int kLeastRow = 32;    ///< least length of a row for the kernels of whole rows [px]
constexpr int kFastReach = 3;    ///< radius of FAST's circle [px]
constexpr int kSmoothReach = 3;  ///< radius of the smoothing filter [px]
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
  /// FAST-9 scores (Rosten and Drummond 2006): the smallest threshold at which a pixel is no longer a corner; 0 for
  /// pixels that are no corner at `threshold`. @param row first of `count` pixels; the circle around each must be
  /// readable.
  void (*cornerScores)(const std::uint8_t* row, std::ptrdiff_t stride, int count, int threshold,
                       std::uint8_t* scores);

  /// Keeps the scores that are larger than all eight neighbours, and sets the others to 0.
  /// @param scores three rows: above, this, below; readable from -1 to `count`.
  void (*localMaxima)(const std::uint8_t* const scores[3], int count, std::uint8_t* maxima);

  /// Vertical Gaussian filter with standard deviation 2 px for one row: rows[0..6] are the seven rows around it.
  void (*smoothColumns)(const std::uint8_t* const rows[7], int count, std::uint8_t* out);
  /// The same along the row, which must be readable from -3 to `count` + 2.
  void (*smoothRow)(const std::uint8_t* row, int count, std::uint8_t* out);

  /// @param centre readable from -15 to +16 px along each row of the disc.
  DiscMoments (*discMoments)(const std::uint8_t* centre, std::ptrdiff_t stride);

  /// Tests of a rotated pattern. Bit k is set if the first point of test k is darker. @param cosine, sine of the angle,
  /// times 2^14. @param out 32 bytes, bit k in byte k / 8.
  void (*describe)(const std::uint8_t* centre, std::ptrdiff_t stride, const BriefPattern& pattern, int cosine,
                   int sine, std::uint8_t* out);

  /// Number of differing bits of two descriptors of 32 bytes.
  int (*hammingDistance)(const std::uint8_t* a, const std::uint8_t* b);
  /// The same between one descriptor and `count` consecutive others.
  void (*hammingDistances)(const std::uint8_t* one, const std::uint8_t* others, std::size_t count,
                           int* distances);
};

/// The kernels of a level. AVX-512 has those of AVX2. All other levels have those of the basic instruction set.
/// @throws std::invalid_argument if this processor lacks the level.
const FeatureKernels& featureKernels(SimdLevel level = bestSimdLevel());

}  // namespace ratslam
