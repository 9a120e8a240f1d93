#include "ratslam/local_view/block_sad/view_template.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace ratslam {
namespace {

TemplateParams sized(int columns, int rows) {
  TemplateParams params;
  params.x_size = columns;
  params.y_size = rows;
  return params;
}

TEST(ViewTemplate, TakesTheMeansOfBlocksOfTheCrop) {
  cv::Mat image(9, 11, CV_8UC1,
                cv::Scalar(255));  // what lies outside the crop or in its remainder stays white
  for (int y = 0; y < 4; ++y) {
    for (int x = 0; x < 6; ++x) image.at<std::uint8_t>(2 + y, 3 + x) = static_cast<std::uint8_t>(10 * y + x);
  }
  TemplateParams params = sized(3, 2);
  params.crop_x_min = 3;
  params.crop_x_max = 11;  // 8 pixels: 3 blocks of 2
  params.crop_y_min = 2;
  params.crop_y_max = 7;  // 5 pixels: 2 blocks of 2
  const ViewTemplate made = makeViewTemplate(image, params);
  const double expected[] = {5.5, 7.5, 9.5, 25.5, 27.5, 29.5};
  ASSERT_EQ(made.values.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_DOUBLE_EQ(made.values[i], expected[i] / 255.0);
  EXPECT_DOUBLE_EQ(made.mean, 17.5 / 255.0);
}

TEST(ViewTemplate, ScalesToTheMeanAndClamps) {
  cv::Mat image = (cv::Mat_<std::uint8_t>(1, 4) << 10, 20, 30, 40);
  TemplateParams params = sized(4, 1);
  params.normalisation = 0.5;
  const ViewTemplate scaled = makeViewTemplate(image, params);
  EXPECT_NEAR(scaled.mean, 0.5, 1e-15);
  EXPECT_NEAR(scaled.values[3], 0.8, 1e-15);

  params.normalisation = 1.0;
  const ViewTemplate clamped = makeViewTemplate(image, params);
  EXPECT_EQ(clamped.values[3], 1.0);
  EXPECT_NEAR(clamped.values[0], 0.4, 1e-15);
}

TEST(ViewTemplate, LeavesABlackImageBlack) {
  TemplateParams params = sized(4, 2);
  params.normalisation = 0.4;
  const ViewTemplate made = makeViewTemplate(cv::Mat(8, 8, CV_8UC1, cv::Scalar(0)), params);
  EXPECT_EQ(made.values, std::vector<double>(8, 0.0));
}

TEST(ViewTemplate, PatchesForgetBrightnessAndContrast) {
  cv::Mat image(10, 16, CV_8UC1);
  for (int i = 0; i < 160; ++i)
    image.at<std::uint8_t>(i / 16, i % 16) = static_cast<std::uint8_t>(i * 37 % 101);
  cv::Mat other;
  image.convertTo(other, CV_8UC1, 2.0, 50.0);
  TemplateParams params = sized(16, 10);
  params.patch_radius = 2;
  const ViewTemplate a = makeViewTemplate(image, params);
  const ViewTemplate b = makeViewTemplate(other, params);
  for (std::size_t i = 0; i < a.values.size(); ++i) EXPECT_NEAR(a.values[i], b.values[i], 1e-12);
  EXPECT_GT(*std::max_element(a.values.begin(), a.values.end()), 0.6);
  EXPECT_LT(*std::min_element(a.values.begin(), a.values.end()), 0.4);
}

TEST(ViewTemplate, MarksFeaturelessPatches) {
  TemplateParams params = sized(8, 8);
  params.patch_radius = 1;
  // 1/3 of white has no exact mean: flat must not depend on its rounding.
  const cv::Mat flat(8, 8, CV_8UC1, cv::Scalar(85));
  EXPECT_EQ(makeViewTemplate(flat, params).values, std::vector<double>(64, 1.0));
  params.min_patch_std = 0.01;
  EXPECT_EQ(makeViewTemplate(flat, params).values, std::vector<double>(64, 0.5));
  cv::Mat nearly_flat = flat.clone();
  nearly_flat.at<std::uint8_t>(4, 4) = 88;
  EXPECT_EQ(makeViewTemplate(nearly_flat, params).values, std::vector<double>(64, 0.5));
  params.min_patch_std = 0.001;
  EXPECT_NE(makeViewTemplate(nearly_flat, params).values[4 * 8 + 4], 0.5);
}

}  // namespace
}  // namespace ratslam
