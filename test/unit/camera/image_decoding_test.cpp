#include "ratslam/camera/image_decoding.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace ratslam {
namespace {

using Bytes = std::vector<std::uint8_t>;

RawImage raw(const std::string& encoding, std::uint32_t width, std::uint32_t height, std::uint32_t step,
             const Bytes& data) {
  return {width, height, step, encoding, false, data.data(), data.size()};
}

std::string refusal(const std::function<void()>& decode) {
  try {
    decode();
  } catch (const BadImage& e) {
    return e.what();
  }
  return "";
}

Bytes encoded(const std::string& ending, const cv::Mat& image) {
  Bytes bytes;
  cv::imencode(ending, image, bytes);
  return bytes;
}

cv::Mat gradient(int type = CV_8UC1) {
  cv::Mat grey(40, 60, CV_8UC1);
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x)
      grey.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(4 * x + y % 7);
  }
  if (type == CV_8UC1) return grey;
  cv::Mat colours;
  cv::cvtColor(grey, colours, cv::COLOR_GRAY2BGR);
  return colours;
}

TEST(RawDecoding, SizesAreCheckedIn64Bits) {
  const Bytes few(44);
  // height * step wraps to 44 at 32 bits.
  EXPECT_NE(refusal([&] { decodeRaw(raw("mono8", 160, 60, 71582789, few)); }).find("malformed"),
            std::string::npos);
  EXPECT_NE(refusal([&] { decodeRaw(raw("mono8", 4294967295U, 4294967295U, 4294967295U, few)); }), "");
  EXPECT_NE(refusal([&] { decodeRaw(raw("rgb8", 1431655766U, 1, 2, few)); }), "");
  EXPECT_NE(refusal([&] { decodeRaw(raw("mono8", 0, 60, 160, few)); }), "");
}

TEST(RawDecoding, RowsOfHalfPixelsAreMalformed) {
  const Bytes data(100);
  EXPECT_NE(refusal([&] { decodeRaw(raw("mono16", 4, 3, 9, data)); }).find("malformed"), std::string::npos);
  EXPECT_NE(refusal([&] { decodeRaw(raw("16UC1", 1, 1, 3, data)); }).find("malformed"), std::string::npos);
}

TEST(RawDecoding, TheLastRowNeedsNoPadding) {
  Bytes data(3 * 8 + 4);
  for (std::size_t i = 0; i < data.size(); ++i) data[i] = static_cast<std::uint8_t>(i);
  const cv::Mat image = decodeRaw(raw("8UC1", 4, 4, 8, data));
  EXPECT_EQ(image.at<std::uint8_t>(3, 3), 27);
}

TEST(RawDecoding, PixelsAreOfTheirOwn) {
  Bytes data(16, 5);
  const cv::Mat image = decodeRaw(raw("mono8", 4, 4, 4, data));
  data.assign(16, 9);
  EXPECT_EQ(image.at<std::uint8_t>(0, 0), 5);
}

TEST(RawDecoding, LuminanceOfYuv) {
  const Bytes uyvy{100, 1, 110, 2, 100, 3, 110, 4};
  const Bytes yuy2{1, 100, 2, 110, 3, 100, 4, 110};
  const cv::Mat expected = (cv::Mat_<std::uint8_t>(1, 4) << 1, 2, 3, 4);
  EXPECT_EQ(cv::norm(decodeRaw(raw("yuv422", 4, 1, 8, uyvy)), expected, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(decodeRaw(raw("yuv422_yuy2", 4, 1, 8, yuy2)), expected, cv::NORM_INF), 0.0);
}

TEST(RawDecoding, NamesWithoutAMeaningAreThoseOfTheirPixels) {
  const Bytes data{1, 2, 3, 4, 5, 6};
  EXPECT_EQ(
      cv::norm(decodeRaw(raw("8UC3", 2, 1, 6, data)), decodeRaw(raw("bgr8", 2, 1, 6, data)), cv::NORM_INF),
      0.0);
  EXPECT_EQ(decodeRaw(raw("16UC1", 3, 1, 6, data)).type(), CV_16UC1);
  EXPECT_EQ(decodeRaw(raw("rgb16", 1, 1, 6, data)).type(), CV_16UC3);
}

TEST(CompressedDecoding, OnlyJpegAndPngReachADecoder) {
  const cv::Mat image = gradient();
  for (const char* ending : {".bmp", ".pgm", ".tiff", ".webp"}) {
    Bytes bytes;
    try {
      bytes = encoded(ending, image);
    } catch (const cv::Exception&) {
      continue;  // this OpenCV cannot write it
    }
    EXPECT_NE(refusal([&] { decodeCompressed(bytes.data(), bytes.size()); }).find("neither JPEG nor PNG"),
              std::string::npos)
        << ending;
  }
}

TEST(CompressedDecoding, IsMeasuredFirst) {
  Bytes png = encoded(".png", cv::Mat(3000, 4000, CV_8UC1, cv::Scalar(0)));
  EXPECT_EQ(measureCompressed(png.data(), png.size()), cv::Size(4000, 3000));
  const std::string why = refusal([&] { decodeCompressed(png.data(), png.size(), ImageLimits{11999999}); });
  png[16] = 0xFF;
  EXPECT_NE(
      refusal([&] { measureCompressed(png.data(), png.size()); }).find("a PNG of 4278194080x3000 pixels"),
      std::string::npos);
  EXPECT_NE(why.find("4000x3000"), std::string::npos) << why;
  EXPECT_NE(why.find("image_max_pixels"), std::string::npos) << why;
  const Bytes jpeg = encoded(".jpg", gradient(CV_8UC3));
  EXPECT_EQ(measureCompressed(jpeg.data(), jpeg.size()), cv::Size(60, 40));
}

TEST(CompressedDecoding, EveryBeginningOfAFileIsRefused) {
  for (const char* ending : {".jpg", ".png"}) {
    const Bytes whole = encoded(ending, gradient(CV_8UC3));
    for (std::size_t size = 0; size + 12 < whole.size(); ++size) {
      EXPECT_NE(refusal([&] { decodeCompressed(whole.data(), size); }), "") << ending << ' ' << size;
    }
  }
}

/// A JPEG with a segment that holds another, smaller one, as cameras store thumbnails.
Bytes withThumbnail(const Bytes& jpeg) {
  const Bytes small = encoded(".jpg", cv::Mat(8, 8, CV_8UC1, cv::Scalar(90)));
  const std::size_t length = small.size() + 2;
  Bytes result{jpeg[0],
               jpeg[1],
               0xFF,
               0xE1,
               static_cast<std::uint8_t>(length >> 8),
               static_cast<std::uint8_t>(length & 0xFF)};
  for (const std::uint8_t byte : small) result.push_back(byte);
  for (std::size_t i = 2; i < jpeg.size(); ++i) result.push_back(jpeg[i]);
  return result;
}

TEST(CompressedDecoding, AThumbnailsEndIsNotTheImages) {
  Bytes jpeg = withThumbnail(encoded(".jpg", gradient()));
  EXPECT_EQ(decodeCompressed(jpeg.data(), jpeg.size()).size(), cv::Size(60, 40));
  jpeg.resize(jpeg.size() - 200);
  EXPECT_NE(refusal([&] { decodeCompressed(jpeg.data(), jpeg.size()); }).find("cut off"), std::string::npos);
}

TEST(CompressedDecoding, PixelsComeOutAsModelsTakeThem) {
  cv::Mat alpha;
  cv::cvtColor(gradient(), alpha, cv::COLOR_GRAY2BGRA);
  alpha.forEach<cv::Vec4b>([](cv::Vec4b& pixel, const int*) { pixel[3] = 7; });
  Bytes png = encoded(".png", alpha);
  EXPECT_EQ(cv::norm(decodeCompressed(png.data(), png.size()), gradient(CV_8UC3), cv::NORM_INF), 0.0);
  cv::Mat deep;
  gradient(CV_8UC3).convertTo(deep, CV_16U, 257.0);
  png = encoded(".png", deep);
  EXPECT_EQ(cv::norm(decodeCompressed(png.data(), png.size()), deep, cv::NORM_INF), 0.0);
  cv::Mat deep_grey;
  gradient().convertTo(deep_grey, CV_16U, 257.0);
  png = encoded(".png", deep_grey);
  EXPECT_EQ(cv::norm(decodeCompressed(png.data(), png.size()), deep_grey, cv::NORM_INF), 0.0);
}

TEST(ImageFiles, WhatIsNoFileIsSaid) {
  const auto folder = std::filesystem::temp_directory_path();
  EXPECT_NE(refusal([&] { decodeImageFile((folder / "no_such_image.png").string()); }).find("no such file"),
            std::string::npos);
  EXPECT_NE(refusal([&] { decodeImageFile(folder.string()); }).find("no ordinary file"), std::string::npos);
}

TEST(ImageFiles, OrientationTagsAreNotObeyed) {
  // EXIF with the one entry Orientation = 6 (turn by 90 degrees), big-endian.
  const Bytes exif{0xFF, 0xE1, 0x00, 0x22, 'E',  'x',  'i',  'f',  0x00, 0x00, 'M',  'M',
                   0x00, 0x2A, 0x00, 0x00, 0x00, 0x08, 0x00, 0x01, 0x01, 0x12, 0x00, 0x03,
                   0x00, 0x00, 0x00, 0x01, 0x00, 0x06, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00};
  Bytes jpeg = encoded(".jpg", gradient());
  jpeg.insert(jpeg.begin() + 2, exif.begin(), exif.end());
  const std::string path = (std::filesystem::temp_directory_path() / "ratslam_turned_by_tag.jpg").string();
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(jpeg.data()), static_cast<std::streamsize>(jpeg.size()));
  EXPECT_EQ(decodeImageFile(path).size(), cv::Size(60, 40));
  EXPECT_EQ(measureImageFile(path), cv::Size(60, 40));
  EXPECT_EQ(decodeCompressed(jpeg.data(), jpeg.size()).size(), cv::Size(60, 40));
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace ratslam
