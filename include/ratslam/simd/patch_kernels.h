/// Arithmetic on the grey values of patches. It is compiled for several instruction sets, one of which is selected at run
/// time. Every level gives the same bits: sums always have sixteen partial sums, one per column, and products are not
/// fused.
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

/// The expected appearance of a patch, with its gradients.
struct PatchTemplate {
  float value[kPatchArea];  ///< grey values without their mean; the gradients are also without their means
  float gradient_x[kPatchArea];
  float gradient_y[kPatchArea];
  float mean = 0.0F;  ///< mean that was subtracted from `value`
};

/// Sums of products over a template.
struct TemplateSums {
  float value_value = 0.0F;
  float value_x = 0.0F;
  float value_y = 0.0F;
  float x_x = 0.0F;
  float x_y = 0.0F;
  float y_y = 0.0F;
};

/// Sums over a patch of an image, of its grey values minus the template's mean.
struct PatchSums {
  float value = 0.0F;
  float square = 0.0F;
  float product = 0.0F;  ///< sum of products with the template
  float along_x = 0.0F;  ///< sums of products with its gradients
  float along_y = 0.0F;
};

struct PatchKernels {
  /// Bilinear samples of an image at `origin` + `step` (u, v), where u counts columns and v rows of the rim.
  /// @param origin x, y. @param step 2 x 2, row-major. @param rim [out] kRimStorage values, the last ones
  /// unused.
  void (*sampleRim)(const std::uint8_t* image, std::ptrdiff_t stride, const float* origin, const float* step,
                    float* rim);

  /// Values and central differences of the patch inside the rim.
  TemplateSums (*fillTemplate)(const float* rim, PatchTemplate& patch);

  /// Compares the template with the upright patch whose corner is at `corner` + (fx, fy), both in [0, 1).
  PatchSums (*compare)(const std::uint8_t* corner, std::ptrdiff_t stride, float fx, float fy,
                       const PatchTemplate& patch);
};

/// The kernels of a level: those of AVX-512 or AVX2, and for all other levels those of the basic instruction set.
/// @throws std::invalid_argument if this processor lacks the level.
const PatchKernels& patchKernels(SimdLevel level = bestSimdLevel());

}  // namespace ratslam
