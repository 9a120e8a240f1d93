/// Arithmetic on the grey values of patches, compiled for several instruction sets and chosen at run time.
/// Sums always have sixteen partial sums, one a column, and products are not fused: every level gives the
/// same bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "ratslam/simd/simd_level.h"

namespace ratslam {

constexpr int kPatchColumns = 16;
constexpr int kPatchRows = 10;
constexpr int kPatchArea = kPatchColumns * kPatchRows;
// With the border that central differences need.
constexpr int kRimColumns = kPatchColumns + 2;
constexpr int kRimArea = kRimColumns * (kPatchRows + 2);
constexpr int kRimStorage = (kRimArea + 15) / 16 * 16;

/// What a patch should look like, with its gradients.
struct PatchTemplate {
  float value[kPatchArea];  ///< mean taken off, like both gradients
  float gradient_x[kPatchArea];
  float gradient_y[kPatchArea];
  float mean = 0.0F;  ///< that was taken off `value`
};

/// Sums over a template, of products.
struct TemplateSums {
  float value_value = 0.0F;
  float value_x = 0.0F;
  float value_y = 0.0F;
  float x_x = 0.0F;
  float x_y = 0.0F;
  float y_y = 0.0F;
};

/// Sums over a patch of an image, its grey values less the template's mean.
struct PatchSums {
  float value = 0.0F;
  float square = 0.0F;
  float product = 0.0F;  ///< with the template
  float along_x = 0.0F;  ///< with its gradients
  float along_y = 0.0F;
};

struct PatchKernels {
  /// Bilinear samples of an image at `origin` + `step` (u, v), u counting columns and v rows of the rim.
  /// @param origin x, y. @param step 2 x 2, row-major. @param rim [out] kRimStorage values, the last ones
  /// unused.
  void (*sampleRim)(const std::uint8_t* image, std::ptrdiff_t stride, const float* origin, const float* step,
                    float* rim);

  /// Values and central differences of the patch inside the rim.
  TemplateSums (*fillTemplate)(const float* rim, PatchTemplate& patch);

  /// Compares the template with the upright patch whose corner lies at `corner` + (fx, fy), both in [0, 1).
  PatchSums (*compare)(const std::uint8_t* corner, std::ptrdiff_t stride, float fx, float fy,
                       const PatchTemplate& patch);
};

/// Those of AVX-512 or AVX2, and for every other level what all machines of the architecture have.
/// @throws std::invalid_argument where this processor lacks the level.
const PatchKernels& patchKernels(SimdLevel level = bestSimdLevel());

}  // namespace ratslam
