/// The arithmetic of features against plain definitions, and at every instruction set.
#include "ratslam/simd/feature_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <opencv2/features2d.hpp>
#include <random>

#include "ratslam/vision/feature_extractor.h"
#include "unit/orb_odometry/street_scene.h"

namespace ratslam {
namespace {

cv::Mat street() { return test::StreetScene().render(test::smallCamera(), test::cameraAt(0, 0)); }

class FeatureKernelsAt : public testing::TestWithParam<SimdLevel> {
 protected:
  const FeatureKernels& kernels = featureKernels(GetParam());
};

TEST_P(FeatureKernelsAt, CornersAreThoseOfOpenCvsFast) {
  constexpr int kThreshold = 7;
  const cv::Mat image = street();
  const int width = image.cols - 2 * kFastReach;
  cv::Mat scores(image.size(), CV_8UC1, cv::Scalar(0));
  for (int y = kFastReach; y < image.rows - kFastReach; ++y) {
    kernels.cornerScores(image.ptr(y) + kFastReach, static_cast<std::ptrdiff_t>(image.step), width,
                         kThreshold, scores.ptr(y) + kFastReach);
  }
  std::vector<cv::KeyPoint> expected;
  cv::FAST(image, expected, kThreshold, true);
  ASSERT_GT(expected.size(), 500U);
  cv::Mat wanted(image.size(), CV_8UC1, cv::Scalar(0));
  for (const cv::KeyPoint& corner : expected) {
    // OpenCV's response is the largest threshold that the corner still passes.
    wanted.at<std::uint8_t>(cv::Point(corner.pt)) = static_cast<std::uint8_t>(corner.response + 1);
  }
  cv::Mat maxima(image.size(), CV_8UC1, cv::Scalar(0));
  for (int y = kFastReach; y < image.rows - kFastReach; ++y) {
    const std::uint8_t* const rows[3] = {scores.ptr(y - 1) + kFastReach, scores.ptr(y) + kFastReach,
                                         scores.ptr(y + 1) + kFastReach};
    kernels.localMaxima(rows, width, maxima.ptr(y) + kFastReach);
  }
  EXPECT_EQ(cv::norm(maxima, wanted, cv::NORM_INF), 0.0);
}

TEST_P(FeatureKernelsAt, SmoothingIsAGaussian) {
  const cv::Mat image = street();
  const int width = image.cols - 2 * kSmoothReach;
  cv::Mat expected;
  cv::GaussianBlur(image, expected, {7, 7}, 2.0);
  std::vector<std::uint8_t> column(static_cast<std::size_t>(image.cols));
  std::vector<std::uint8_t> row(static_cast<std::size_t>(width));
  for (int y = kSmoothReach; y < image.rows - kSmoothReach; ++y) {
    const std::uint8_t* rows[7];
    for (int i = 0; i < 7; ++i) rows[i] = image.ptr(y + i - kSmoothReach);
    kernels.smoothColumns(rows, image.cols, column.data());
    kernels.smoothRow(column.data() + kSmoothReach, width, row.data());
    for (int x = 0; x < width; ++x) {
      ASSERT_NEAR(row[static_cast<std::size_t>(x)], expected.at<std::uint8_t>(y, x + kSmoothReach), 2)
          << x << ' ' << y;
    }
  }
}

TEST_P(FeatureKernelsAt, MomentsAreSumsOverTheDisc) {
  cv::Mat image(40, 64, CV_8UC1);
  cv::RNG generator(1);
  for (const int brightest : {2, 256}) {
    generator.fill(image, cv::RNG::UNIFORM, brightest - 2,
                   brightest);  // nearly black, and white to overflow sums
    if (brightest == 256) image.rowRange(0, 20).setTo(0);
    DiscMoments expected;
    for (int v = -kDiscRadius; v <= kDiscRadius; ++v) {
      for (int u = -kDiscRadius; u <= kDiscRadius; ++u) {
        if (u * u + v * v > kDiscRadius * kDiscRadius) continue;
        expected.x += u * image.at<std::uint8_t>(20 + v, 30 + u);
        expected.y += v * image.at<std::uint8_t>(20 + v, 30 + u);
      }
    }
    const DiscMoments moments =
        kernels.discMoments(image.ptr(20) + 30, static_cast<std::ptrdiff_t>(image.step));
    EXPECT_EQ(moments.x, expected.x);
    EXPECT_EQ(moments.y, expected.y);
  }
}

TEST_P(FeatureKernelsAt, HammingDistanceCountsBits) {
  std::mt19937 random(2);
  std::array<std::uint8_t, 32> a{};
  std::array<std::uint8_t, 32> b{};
  for (std::size_t i = 0; i < 32; ++i) {
    a[i] = static_cast<std::uint8_t>(random());
    b[i] = static_cast<std::uint8_t>(random());
  }
  int expected = 0;
  for (std::size_t bit = 0; bit < 256; ++bit) expected += ((a[bit / 8] ^ b[bit / 8]) >> (bit % 8)) & 1;
  EXPECT_EQ(kernels.hammingDistance(a.data(), b.data()), expected);
  std::array<std::uint8_t, 64> others{};
  std::copy(b.begin(), b.end(), others.begin() + 32);
  int distances[2] = {};
  kernels.hammingDistances(b.data(), others.data(), 2, distances);
  EXPECT_EQ(distances[0], kernels.hammingDistance(b.data(), others.data()));
  EXPECT_EQ(distances[1], 0);
  b = a;
  EXPECT_EQ(kernels.hammingDistance(a.data(), b.data()), 0);
}

TEST_P(FeatureKernelsAt, FeaturesDoNotDependOnTheInstructionSet) {
  const ExtractorParams params;
  const ImagePyramid pyramid(street(), params.levels, params.scale_factor);
  WorkerPool workers(1);
  cv::Mat descriptors;
  cv::Mat scalar_descriptors;
  const auto features = FeatureExtractor(params, GetParam()).extract(pyramid, descriptors, workers);
  const auto scalar =
      FeatureExtractor(params, SimdLevel::kScalar).extract(pyramid, scalar_descriptors, workers);
  ASSERT_EQ(features.size(), scalar.size());
  ASSERT_GT(features.size(), 500U);
  for (std::size_t i = 0; i < features.size(); ++i) {
    EXPECT_EQ(features[i].raw, scalar[i].raw);
    EXPECT_EQ(features[i].angle_deg, scalar[i].angle_deg);
  }
  EXPECT_EQ(cv::norm(descriptors, scalar_descriptors, cv::NORM_HAMMING), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Levels, FeatureKernelsAt, testing::ValuesIn(availableSimdLevels()));

}  // namespace
}  // namespace ratslam
