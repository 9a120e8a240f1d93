#include "ratslam/camera/grey.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <random>
#include <string>

namespace ratslam {
namespace {

cv::Mat randomBytes(int rows, int columns, int type, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> value(0, 255);
  cv::Mat image(rows, columns, type);
  for (int y = 0; y < rows; ++y) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(columns) * image.elemSize(); ++i) {
      image.ptr<std::uint8_t>(y)[i] = static_cast<std::uint8_t>(value(random));
    }
  }
  return image;
}

cv::Rect whole(const cv::Mat& image) { return {0, 0, image.cols, image.rows}; }

std::string messageOf(const cv::Mat& image) {
  try {
    pixelFormat(image);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing thrown";
}

TEST(SumBlocks, SumsWhatOpenCvSums) {
  for (const int type : {CV_8UC1, CV_16UC1}) {
    const cv::Mat image = randomBytes(37, 53, type, 4);
    const cv::Rect region(5, 3, 44, 30);
    const BlockSums blocks = sumBlocks(image, region, 6, 4);  // of 7 x 7 pixels
    ASSERT_EQ(blocks.sums.size(), 24U);
    for (int j = 0; j < 4; ++j) {
      for (int i = 0; i < 6; ++i) {
        const double expected = cv::sum(image(cv::Rect(5 + 7 * i, 3 + 7 * j, 7, 7)))[0];
        EXPECT_EQ(static_cast<double>(blocks.sums[static_cast<std::size_t>(6 * j + i)]), expected);
      }
    }
    EXPECT_EQ(blocks.full_scale, 49U * (type == CV_8UC1 ? 255U : 65535U));
  }
}

TEST(SumBlocks, WhiteIsFullScaleInEveryFormat) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1}) {
    const double white = type == CV_16UC1 ? 65535.0 : 255.0;
    const cv::Mat image(12, 20, type, cv::Scalar::all(white));
    const BlockSums blocks = sumBlocks(image, whole(image), 5, 3);
    for (const std::uint64_t sum : blocks.sums) EXPECT_EQ(sum, blocks.full_scale);
  }
}

TEST(SumBlocks, GreyIsTheMeanOfTheColoursInAnyOrderWithoutAlpha) {
  const cv::Mat bgr = randomBytes(20, 30, CV_8UC3, 8);
  cv::Mat rgb;
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  cv::Mat bgra;
  cv::cvtColor(bgr, bgra, cv::COLOR_BGR2BGRA);
  cv::Mat transparent = bgra.clone();
  for (auto it = transparent.begin<cv::Vec4b>(); it != transparent.end<cv::Vec4b>(); ++it) (*it)[3] = 3;
  const BlockSums expected = sumBlocks(bgr, whole(bgr), 10, 5);
  const cv::Scalar corner = cv::sum(bgr(cv::Rect(0, 0, 3, 4)));
  EXPECT_EQ(static_cast<double>(expected.sums[0]), corner[0] + corner[1] + corner[2]);
  for (const cv::Mat& image : {rgb, bgra, transparent}) {
    const BlockSums blocks = sumBlocks(image, whole(image), 10, 5);
    EXPECT_EQ(blocks.sums, expected.sums);
    EXPECT_EQ(blocks.full_scale, expected.full_scale);
  }
}

TEST(SumBlocks, ReadsImagesOfAnyRowStride) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1}) {
    const cv::Mat wide = randomBytes(24, 71, type, 15);
    const cv::Mat part = wide(cv::Rect(9, 2, 40, 20));
    ASSERT_FALSE(part.isContinuous());
    EXPECT_EQ(sumBlocks(part, whole(part), 8, 5).sums, sumBlocks(part.clone(), whole(part), 8, 5).sums);
  }
}

TEST(SumBlocks, RefusesRegionsThatDoNotFit) {
  const cv::Mat image(20, 30, CV_8UC1, cv::Scalar(1));
  EXPECT_THROW(sumBlocks(image, cv::Rect(1, 0, 30, 20), 2, 2), std::invalid_argument);
  EXPECT_THROW(sumBlocks(image, cv::Rect(-1, 0, 20, 20), 2, 2), std::invalid_argument);
  EXPECT_THROW(sumBlocks(image, cv::Rect(0, 0, 30, 20), 31, 2), std::invalid_argument);
  EXPECT_THROW(sumBlocks(image, cv::Rect(0, 0, 30, 20), 2, 0), std::invalid_argument);
}

TEST(EightBitGrey, IsTheSameFromEveryPixelFormat) {
  const cv::Mat grey = randomBytes(24, 40, CV_8UC1, 5);
  cv::Mat colour;
  cv::Mat alpha;
  cv::Mat deep;
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
  cv::cvtColor(grey, alpha, cv::COLOR_GRAY2BGRA);
  grey.convertTo(deep, CV_16U, 257.0);
  for (const cv::Mat& image : {grey, colour, alpha, deep})
    EXPECT_EQ(cv::norm(eightBitGrey(image), grey, cv::NORM_INF), 0.0) << cv::typeToString(image.type());
  EXPECT_THROW(eightBitGrey(cv::Mat(4, 4, CV_32FC1)), std::invalid_argument);
}

TEST(PixelFormat, NamesWhatIsWrongWithAnImage) {
  EXPECT_EQ(messageOf(cv::Mat()), "image: it is empty");
  EXPECT_NE(messageOf(cv::Mat(4, 4, CV_32FC1, cv::Scalar(0))).find("unsupported type CV_32FC1"),
            std::string::npos);
  EXPECT_NE(messageOf(cv::Mat(4, 4, CV_8UC2, cv::Scalar(0))).find("unsupported type CV_8UC2"),
            std::string::npos);
  EXPECT_NE(messageOf(cv::Mat(4, 4, CV_16UC3, cv::Scalar(0))).find("unsupported type CV_16UC3"),
            std::string::npos);
}

}  // namespace
}  // namespace ratslam
