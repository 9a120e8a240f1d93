/// The arithmetic of patches against its definition, and at every instruction set.
#include "ratslam/simd/patch_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <opencv2/core.hpp>

#include "unit/orb_odometry/street_scene.h"

namespace ratslam {
namespace {

double bilinear(const cv::Mat& image, double x, double y) {
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const double fx = x - column;
  const double fy = y - row;
  const auto at = [&](int v, int u) { return static_cast<double>(image.at<std::uint8_t>(v, u)); };
  return (1 - fy) * ((1 - fx) * at(row, column) + fx * at(row, column + 1)) +
         fy * ((1 - fx) * at(row + 1, column) + fx * at(row + 1, column + 1));
}

class PatchKernelsAt : public testing::TestWithParam<SimdLevel> {
 protected:
  const PatchKernels& kernels = patchKernels(GetParam());
  const PatchKernels& scalar = patchKernels(SimdLevel::kScalar);
  const cv::Mat image = test::StreetScene().render(test::smallCamera(), test::cameraAt(0, 0));
  const std::ptrdiff_t stride = static_cast<std::ptrdiff_t>(image.step);
  static constexpr float kOrigin[2] = {100.3F, 60.8F};
  static constexpr float kStep[4] = {1.1F, 0.2F, -0.15F, 0.9F};
};

TEST_P(PatchKernelsAt, SampleTheWarpedPatch) {
  float rim[kRimStorage];
  kernels.sampleRim(image.data, stride, kOrigin, kStep, rim);
  for (int i = 0; i < kRimArea; ++i) {
    const double u = i % kRimColumns;
    const double v = i / kRimColumns;
    const double expected = bilinear(image, static_cast<double>(kOrigin[0]) + 1.1 * u + 0.2 * v,
                                     static_cast<double>(kOrigin[1]) - 0.15 * u + 0.9 * v);
    EXPECT_NEAR(rim[i], expected, 0.01) << i;
  }
}

TEST_P(PatchKernelsAt, FindNoDifferenceBetweenAPatchAndItself) {
  const float upright[4] = {1.0F, 0.0F, 0.0F, 1.0F};
  const float origin[2] = {99.25F, 59.5F};  // of the rim: the patch begins one pixel further in
  float rim[kRimStorage];
  kernels.sampleRim(image.data, stride, origin, upright, rim);
  PatchTemplate patch;
  const TemplateSums made = kernels.fillTemplate(rim, patch);
  const PatchSums sums = kernels.compare(image.ptr(60) + 100, stride, 0.25F, 0.5F, patch);
  EXPECT_GT(made.value_value, 0.0F);
  EXPECT_NEAR(sums.value, 0.0, 1e-2);
  EXPECT_NEAR(sums.square, made.value_value, 1e-3 * made.value_value);
  EXPECT_NEAR(sums.product, made.value_value, 1e-3 * made.value_value);
  EXPECT_NEAR(sums.along_x, made.value_x, 1e-3 * made.value_value);
  EXPECT_NEAR(sums.along_y, made.value_y, 1e-3 * made.value_value);
}

TEST_P(PatchKernelsAt, GiveTheSameBitsAtEveryInstructionSet) {
  float rim[2][kRimStorage];
  kernels.sampleRim(image.data, stride, kOrigin, kStep, rim[0]);
  scalar.sampleRim(image.data, stride, kOrigin, kStep, rim[1]);
  EXPECT_EQ(std::memcmp(rim[0], rim[1], sizeof rim[0]), 0);
  PatchTemplate patch;
  PatchTemplate same;
  const TemplateSums made = kernels.fillTemplate(rim[0], patch);
  const TemplateSums made_too = scalar.fillTemplate(rim[0], same);
  EXPECT_EQ(std::memcmp(&patch, &same, sizeof patch), 0);
  EXPECT_EQ(std::memcmp(&made, &made_too, sizeof made), 0);
  const PatchSums sums = kernels.compare(image.ptr(61) + 102, stride, 0.37F, 0.81F, patch);
  const PatchSums sums_too = scalar.compare(image.ptr(61) + 102, stride, 0.37F, 0.81F, patch);
  EXPECT_EQ(std::memcmp(&sums, &sums_too, sizeof sums), 0);
}

INSTANTIATE_TEST_SUITE_P(Levels, PatchKernelsAt, testing::ValuesIn(availableSimdLevels()));

}  // namespace
}  // namespace ratslam
