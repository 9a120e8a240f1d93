#include "ratslam_ros/support/image_decoding.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

namespace ratslam {
namespace {

/// A raw image whose rows are padded with bytes that must never be read as pixels.
sensor_msgs::ImagePtr paddedImage(const std::string& encoding, unsigned bytes_per_pixel, unsigned padding) {
  auto message = boost::make_shared<sensor_msgs::Image>();
  message->encoding = encoding;
  message->width = 4;
  message->height = 4;
  message->step = message->width * bytes_per_pixel + padding;
  message->data.assign(message->step * message->height, 255);
  for (unsigned row = 0; row < message->height; ++row) {
    for (unsigned i = 0; i < message->width * bytes_per_pixel; ++i) {
      message->data[row * message->step + i] = static_cast<std::uint8_t>(10 * row + i);
    }
  }
  return message;
}

struct EncodingCase {
  std::string encoding;
  unsigned bytes_per_pixel;
  std::vector<unsigned>
      blue_green_red;  ///< where they lie within a pixel; one entry: mono of that many bytes
};

class RawImages : public ::testing::TestWithParam<EncodingCase> {};

TEST_P(RawImages, AreReadRowByRowWhateverTheStride) {
  const EncodingCase& expected = GetParam();
  const bool mono = expected.blue_green_red.size() == 1;
  for (const unsigned padding : {0U, 3U * expected.bytes_per_pixel, 64U}) {
    const auto message = paddedImage(expected.encoding, expected.bytes_per_pixel, padding);
    const cv::Mat image = decodeImage(sensor_msgs::ImageConstPtr(message));
    ASSERT_EQ(image.type(), !mono ? CV_8UC3 : expected.bytes_per_pixel == 2 ? CV_16UC1 : CV_8UC1);
    ASSERT_EQ(image.size(), cv::Size(4, 4));
    for (unsigned row = 0; row < 4; ++row) {
      for (unsigned column = 0; column < 4; ++column) {
        const std::uint8_t* sent = &message->data[row * message->step + column * expected.bytes_per_pixel];
        const std::uint8_t* pixel = image.ptr(static_cast<int>(row)) + column * image.elemSize();
        for (std::size_t i = 0; i < image.elemSize(); ++i) {
          EXPECT_EQ(pixel[i], sent[mono ? i : expected.blue_green_red[i]])
              << row << ' ' << column << ' ' << padding;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Encodings, RawImages,
                         ::testing::Values(EncodingCase{"mono8", 1, {0}}, EncodingCase{"mono16", 2, {0}},
                                           EncodingCase{"bgr8", 3, {0, 1, 2}},
                                           EncodingCase{"rgb8", 3, {2, 1, 0}},
                                           EncodingCase{"bgra8", 4, {0, 1, 2}},
                                           EncodingCase{"rgba8", 4, {2, 1, 0}}),
                         [](const auto& test) { return test.param.encoding; });

TEST(RawImage, BayerMosaicBecomesColour) {
  for (const char* encoding : {"bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8", "bayer_rggb16"}) {
    const unsigned bytes = std::string(encoding) == "bayer_rggb16" ? 2 : 1;
    const cv::Mat image = decodeImage(sensor_msgs::ImageConstPtr(paddedImage(encoding, bytes, 6)));
    EXPECT_EQ(image.type(), bytes == 2 ? CV_16UC3 : CV_8UC3) << encoding;
    EXPECT_EQ(image.size(), cv::Size(4, 4)) << encoding;
  }
}

TEST(RawImage, BigEndianMono16IsSwapped) {
  const auto message = paddedImage("mono16", 2, 0);
  message->is_bigendian = 1;
  const cv::Mat image = decodeImage(sensor_msgs::ImageConstPtr(message));
  EXPECT_EQ(image.at<std::uint16_t>(1, 0), (10 << 8) + 11);
}

TEST(RawImage, UnknownEncodingIsNamed) {
  try {
    decodeImage(sensor_msgs::ImageConstPtr(paddedImage("32FC1", 4, 0)));
    FAIL() << "accepted";
  } catch (const BadImage& e) {
    EXPECT_NE(std::string(e.what()).find("'32FC1'"), std::string::npos) << e.what();
    EXPECT_NE(std::string(e.what()).find("rgb8"), std::string::npos) << e.what();
  }
}

TEST(RawImage, SizesThatContradictTheDataAreRefused) {
  auto message = paddedImage("rgb8", 3, 0);
  message->data.resize(message->data.size() - 1);
  EXPECT_THROW(decodeImage(sensor_msgs::ImageConstPtr(message)), BadImage);
  message = paddedImage("rgb8", 3, 0);
  message->step = 3;
  EXPECT_THROW(decodeImage(sensor_msgs::ImageConstPtr(message)), BadImage);
  EXPECT_THROW(decodeImage(boost::make_shared<const sensor_msgs::Image>()), BadImage);
  message = paddedImage("mono8", 1, 0);
  message->width = message->height = 0;
  message->data.clear();
  EXPECT_THROW(decodeImage(sensor_msgs::ImageConstPtr(message)), BadImage);
}

cv::Mat texture() {
  cv::Mat image(120, 160, CV_8UC3);
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      image.at<cv::Vec3b>(row, column) =
          cv::Vec3b(static_cast<uchar>(row * 7 + column * column), static_cast<uchar>(column * 3),
                    static_cast<uchar>(row * row));
    }
  }
  return image;
}

sensor_msgs::CompressedImagePtr compressed(const std::string& extension, const cv::Mat& image) {
  auto message = boost::make_shared<sensor_msgs::CompressedImage>();
  message->format = extension.substr(1);
  cv::imencode(extension, image, message->data);
  return message;
}

TEST(CompressedImage, PngIsExactInEightAndSixteenBits) {
  const cv::Mat colour = texture();
  const cv::Mat back = decodeImage(sensor_msgs::CompressedImageConstPtr(compressed(".png", colour)));
  EXPECT_EQ(cv::norm(back, colour, cv::NORM_INF), 0.0);
  cv::Mat deep(20, 30, CV_16UC1, cv::Scalar(51234));
  const cv::Mat deep_back = decodeImage(sensor_msgs::CompressedImageConstPtr(compressed(".png", deep)));
  ASSERT_EQ(deep_back.type(), CV_16UC1);
  EXPECT_EQ(cv::norm(deep_back, deep, cv::NORM_INF), 0.0);
}

TEST(CompressedImage, AlphaIsLeftOut) {
  const cv::Mat with_alpha(20, 30, CV_8UC4, cv::Scalar(10, 20, 30, 77));
  const cv::Mat back = decodeImage(sensor_msgs::CompressedImageConstPtr(compressed(".png", with_alpha)));
  ASSERT_EQ(back.type(), CV_8UC3);
  EXPECT_EQ(back.at<cv::Vec3b>(5, 5), cv::Vec3b(10, 20, 30));
}

TEST(CompressedImage, JpegKeepsItsChannels) {
  const cv::Mat colour = texture();
  EXPECT_EQ(decodeImage(sensor_msgs::CompressedImageConstPtr(compressed(".jpg", colour))).channels(), 3);
  cv::Mat grey;
  cv::extractChannel(colour, grey, 1);
  EXPECT_EQ(decodeImage(sensor_msgs::CompressedImageConstPtr(compressed(".jpg", grey))).channels(), 1);
}

TEST(CompressedImage, PaddingAfterAJpegIsHarmless) {
  auto message = compressed(".jpg", texture());
  message->data.insert(message->data.end(), 7, 0);
  EXPECT_EQ(decodeImage(sensor_msgs::CompressedImageConstPtr(message)).size(), cv::Size(160, 120));
}

TEST(CompressedImage, CorruptOrTruncatedIsRefusedWhereverItEnds) {
  const auto whole = compressed(".jpg", texture());
  for (const double kept : {0.0, 0.01, 0.2, 0.5, 0.9}) {
    auto cut = boost::make_shared<sensor_msgs::CompressedImage>(*whole);
    cut->data.resize(static_cast<std::size_t>(kept * static_cast<double>(whole->data.size())));
    EXPECT_THROW(decodeImage(sensor_msgs::CompressedImageConstPtr(cut)), BadImage) << kept;
  }
  auto noise = boost::make_shared<sensor_msgs::CompressedImage>();
  noise->data.assign(5000, 0x5A);
  EXPECT_THROW(decodeImage(sensor_msgs::CompressedImageConstPtr(noise)), BadImage);
  auto png = compressed(".png", texture());
  png->data.resize(png->data.size() / 2);
  EXPECT_THROW(decodeImage(sensor_msgs::CompressedImageConstPtr(png)), BadImage);
}

}  // namespace
}  // namespace ratslam
