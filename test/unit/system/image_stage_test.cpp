#include "ratslam/system/image_stage.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <vector>

#include "ratslam/common/state.h"
#include "ratslam/common/state_image.h"

namespace ratslam {
namespace {

constexpr Stamp kTenth = 100000000;

/// Random texture, another one for each number.
cv::Mat picture(int number, const cv::Size& size = {160, 60}) {
  cv::Mat image(size, CV_8UC1);
  cv::RNG random(static_cast<std::uint64_t>(number) + 1);
  random.fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, cv::Size(0, 0), 5.0);
  cv::normalize(image, image, 20, 230, cv::NORM_MINMAX);
  return image;
}

class ImageStageTest : public ::testing::Test {
 protected:
  std::optional<ImageFrame> add(Stamp stamp, const cv::Mat& image) {
    DecodedImage decoded;
    decoded.stamp = stamp;
    decoded.name = "image " + std::to_string(number_++);
    decoded.image = image;
    if (image.empty()) decoded.error = "cut off";
    return stage_.add(decoded);
  }
  std::optional<ImageFrame> next(const cv::Mat& image) { return add(now_ += kTenth, image); }
  std::size_t count(ImageEvent event) const { return stage_.counts().of(event); }
  void restartWith(const ImageStageParams& params) {
    stage_ = ImageStage(params, [this](ImageEvent, const std::string& text) { told_.push_back(text); });
  }

  std::vector<std::string> told_;
  ImageStage stage_{ImageStageParams{},
                    [this](ImageEvent, const std::string& text) { told_.push_back(text); }};
  Stamp now_ = 1000 * kTenth;
  int number_ = 0;
};

TEST_F(ImageStageTest, HandsOnWhatIsGoodAndSaysNothing) {
  for (int i = 0; i < 5; ++i) {
    const auto frame = next(picture(i));
    ASSERT_TRUE(frame);
    EXPECT_TRUE(frame->usable());
    EXPECT_FALSE(frame->begins_anew);
    EXPECT_EQ(frame->stamp, now_);
  }
  EXPECT_TRUE(told_.empty());
  EXPECT_EQ(stage_.counts().text(), "5 of 5 images used");
}

TEST_F(ImageStageTest, UnreadableImagesAreNamedCountedAndLeftOut) {
  EXPECT_FALSE(next(cv::Mat()));  // the first one, too
  EXPECT_TRUE(next(picture(1)));
  EXPECT_FALSE(next(cv::Mat()));
  EXPECT_EQ(count(ImageEvent::kUnreadable), 2U);
  EXPECT_EQ(told_.at(1), "image 2: image skipped: cut off");
  EXPECT_EQ(stage_.counts().text(), "1 of 3 images used (2 unreadable)");
}

TEST_F(ImageStageTest, AnImageThatModelsRefuseIsNotUsedAndCountsOnce) {
  ASSERT_TRUE(next(picture(0)));
  ASSERT_TRUE(next(picture(1)));
  stage_.refused("image 1", "outside the crop");
  stage_.refused("image 1", "not of the calibration's size");
  ASSERT_TRUE(next(picture(2)));
  stage_.refused("image 2", "outside the crop");
  EXPECT_EQ(stage_.counts().text(), "1 of 3 images used (2 unsuitable)");
  EXPECT_EQ(told_, (std::vector<std::string>{"image 1: image skipped: outside the crop",
                                             "image 1: image skipped: not of the calibration's size",
                                             "image 2: image skipped: outside the crop"}));
}

TEST_F(ImageStageTest, LateImagesAreLeftOutAndTheClockStays) {
  ASSERT_TRUE(add(10 * kTenth, picture(0)));
  ASSERT_TRUE(add(12 * kTenth, picture(1)));
  EXPECT_FALSE(add(11 * kTenth, picture(2)));
  const auto after = add(13 * kTenth, picture(3));
  ASSERT_TRUE(after);
  EXPECT_FALSE(after->begins_anew);
  EXPECT_EQ(count(ImageEvent::kLate), 1U);
  EXPECT_EQ(count(ImageEvent::kBeginsAnew), 0U);
}

TEST_F(ImageStageTest, FurtherBackTimeBeginsAnew) {
  ASSERT_TRUE(add(100 * kTenth, picture(0)));
  const auto frame = add(90 * kTenth, picture(1));  // exactly time_reset
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->begins_anew);
  const auto after = add(91 * kTenth, picture(2));
  ASSERT_TRUE(after);
  EXPECT_FALSE(after->begins_anew);
  EXPECT_EQ(count(ImageEvent::kBeginsAnew), 1U);
  EXPECT_NE(told_.at(0).find("time went back by 1 s"), std::string::npos) << told_.at(0);
}

TEST_F(ImageStageTest, AnImageAheadOfTimeIsNoNewBeginning) {
  ASSERT_TRUE(add(100 * kTenth, picture(0)));
  ASSERT_TRUE(add(101 * kTenth, picture(1)));
  ASSERT_TRUE(add(152 * kTenth, picture(2)));  // cannot be known yet
  State state;
  stage_.save(state);
  restartWith({});
  stage_.load(state);
  ASSERT_TRUE(add(103 * kTenth, picture(3)));
  EXPECT_EQ(count(ImageEvent::kAhead), 1U);
  EXPECT_EQ(count(ImageEvent::kBeginsAnew), 0U);
  EXPECT_NE(told_.at(0).find("the image before it lies ahead of time, by 4.9 s"), std::string::npos)
      << told_.at(0);
  ASSERT_TRUE(add(104 * kTenth, picture(4)));
  ASSERT_TRUE(add(80 * kTenth, picture(5)));
  EXPECT_EQ(count(ImageEvent::kBeginsAnew), 1U) << "it lies before all of them";
}

TEST_F(ImageStageTest, RepeatedAndMissingStampsAreSaid) {
  ASSERT_TRUE(add(0, picture(0)));  // a recording may begin at zero
  EXPECT_FALSE(add(0, picture(1)));
  EXPECT_NE(told_.at(0).find("no stamps"), std::string::npos) << told_.at(0);
  ASSERT_TRUE(add(5 * kTenth, picture(6)));
  EXPECT_EQ(count(ImageEvent::kBeginsAnew), 0U);
  ASSERT_TRUE(add(50 * kTenth, picture(2)));
  EXPECT_FALSE(add(50 * kTenth, picture(3)));
  EXPECT_FALSE(add(0, picture(4)));  // not a new beginning: the driver forgot to stamp
  EXPECT_FALSE(add(-kTenth, picture(5)));
  EXPECT_EQ(count(ImageEvent::kRepeatedStamp), 2U);
  EXPECT_EQ(count(ImageEvent::kNoStamp), 2U);
  EXPECT_EQ(count(ImageEvent::kBeginsAnew), 0U);
}

TEST_F(ImageStageTest, WhatComesAfterAnUnstampedFirstImageIsANewBeginning) {
  ASSERT_TRUE(add(0, picture(0)));
  const auto frame = add(Stamp{1600000000} * 1000000000, picture(1));
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->begins_anew) << "not a step of 50 years";
}

TEST_F(ImageStageTest, OneImageOfAnotherSizeIsLeftOut) {
  for (int i = 0; i < 10; ++i) next(picture(i));
  EXPECT_FALSE(next(picture(10, {80, 60})));
  EXPECT_TRUE(next(picture(11)));
  EXPECT_EQ(count(ImageEvent::kOtherSize), 1U);
  EXPECT_NE(told_.at(0).find("from 160x60 to 80x60"), std::string::npos) << told_.at(0);
}

TEST_F(ImageStageTest, AChangeOfSizeAfterHoursCostsSecondsNotHours) {
  for (int k = 0; k < 500; ++k) ASSERT_TRUE(next(picture(k)));
  int left_out = 0;
  while (left_out < 1000 && !next(picture(left_out, {80, 60}))) ++left_out;
  EXPECT_EQ(left_out, 100);
  EXPECT_TRUE(next(picture(1, {80, 60})));
}

TEST_F(ImageStageTest, AnOddFirstImageDoesNotSetTheSize) {
  ASSERT_TRUE(next(picture(0, {80, 60})));
  EXPECT_FALSE(next(picture(1)));
  const auto frame = next(picture(2));
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->begins_anew);
  EXPECT_TRUE(next(picture(3)));
  EXPECT_FALSE(next(picture(4, {80, 60})));
}

TEST_F(ImageStageTest, FrozenAndBlankFramesAreHandedOnAsSuch) {
  ASSERT_TRUE(next(picture(0))->usable());
  EXPECT_EQ(next(picture(0))->quality, ImageQuality::kFrozen);
  EXPECT_EQ(next(picture(0))->quality, ImageQuality::kFrozen);
  EXPECT_TRUE(next(picture(1))->usable());
  cv::Mat one_pixel_off = picture(1);
  one_pixel_off.at<std::uint8_t>(59, 159) ^= 1;
  EXPECT_TRUE(next(one_pixel_off)->usable());
  EXPECT_EQ(next(cv::Mat(60, 160, CV_8UC1, cv::Scalar(3)))->quality, ImageQuality::kBlank);
  EXPECT_EQ(next(cv::Mat(60, 160, CV_8UC3, cv::Scalar(252, 252, 252)))->quality, ImageQuality::kBlank);
  cv::Mat noise(60, 160, CV_16SC1);
  cv::RNG(3).fill(noise, cv::RNG::NORMAL, 10, 2);
  noise.convertTo(noise, CV_8U);
  EXPECT_EQ(next(noise)->quality, ImageQuality::kBlank) << "a sensor's noise is no texture";
  cv::Mat dusk = picture(2) / 10;
  EXPECT_TRUE(next(dusk)->usable()) << "a dark scene is one";
  EXPECT_EQ(count(ImageEvent::kFrozen), 2U);
  EXPECT_EQ(count(ImageEvent::kBlank), 3U);
  EXPECT_EQ(stage_.counts().used, 9U);
}

TEST_F(ImageStageTest, FewSignificantBitsAreScaledUpAndSaid) {
  cv::Mat twelve;
  picture(0).convertTo(twelve, CV_16U, 16.0);
  const auto frame = next(twelve);
  ASSERT_TRUE(frame);
  cv::Mat expected = twelve * 16;
  EXPECT_EQ(cv::norm(frame->image, expected, cv::NORM_INF), 0.0);
  ASSERT_EQ(told_.size(), 1U);
  EXPECT_NE(told_[0].find("12 bits"), std::string::npos) << told_[0];

  cv::Mat sixteen;
  picture(0).convertTo(sixteen, CV_16U, 257.0);
  restartWith(ImageStageParams{});
  EXPECT_EQ(cv::norm(next(sixteen)->image, sixteen, cv::NORM_INF), 0.0);

  ImageStageParams all_bits;
  all_bits.image_bits = 16;
  restartWith(all_bits);
  EXPECT_EQ(cv::norm(next(twelve)->image, twelve, cv::NORM_INF), 0.0);
}

TEST_F(ImageStageTest, ColoursOfFewSignificantBitsAreScaledUpBeforeTheyGetEightBits) {
  cv::Mat grey = picture(0);
  grey.at<std::uint8_t>(0, 0) = 255;
  cv::Mat eight;
  cv::merge(std::vector<cv::Mat>{grey / 4, grey, grey / 2}, eight);
  for (const int bits : {8, 10, 12, 14, 16}) {
    cv::Mat deep;
    eight.convertTo(deep, CV_16U, static_cast<double>(1 << (bits - 8)));
    told_.clear();
    restartWith(ImageStageParams{});
    const auto frame = next(deep);
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->image.type(), CV_8UC3);
    EXPECT_LE(cv::norm(frame->image, eight, cv::NORM_INF), 1.0) << bits << " bits";
    ASSERT_EQ(told_.size(), bits < 16 ? 1U : 0U);
    if (bits == 16) continue;
    EXPECT_NE(told_[0].find("use " + std::to_string(bits) + " bits"), std::string::npos) << told_[0];
  }
  ImageStageParams fixed;
  fixed.image_bits = 12;
  restartWith(fixed);
  cv::Mat dark;
  eight.convertTo(dark, CV_16U, 1.0);
  EXPECT_LE(cv::norm(next(dark)->image, eight / 16, cv::NORM_INF), 1.0);
}

TEST_F(ImageStageTest, KnowsTheLastImageAgainAfterItWasSaved) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1}) {
    cv::Mat image;
    cv::merge(std::vector<cv::Mat>(static_cast<std::size_t>(CV_MAT_CN(type)), picture(1)), image);
    image.convertTo(image, type, CV_MAT_DEPTH(type) == CV_16U ? 200.0 : 1.0, 0.25);
    restartWith({});
    ASSERT_TRUE(next(image));
    State state;
    stage_.save(state);
    image.setTo(0);  // the camera's memory is used again
    const State saved = State::fromBytes(state.toBytes());
    cv::Mat again = getImage(saved.child("last"));
    restartWith({});
    stage_.load(saved);
    EXPECT_EQ(again.type(), type);
    const auto frame = next(again);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->quality, ImageQuality::kFrozen) << "type " << type;
  }
}

TEST_F(ImageStageTest, ARecordingContinuesTheImagesThatWereUsed) {
  EXPECT_FALSE(stage_.isContinuedBy(kTenth)) << "there are none";
  ASSERT_TRUE(add(100 * kTenth, picture(0)));
  ASSERT_TRUE(add(101 * kTenth, picture(1)));
  EXPECT_FALSE(add(0, picture(2)));  // has no stamp
  EXPECT_TRUE(stage_.isContinuedBy(102 * kTenth));
  EXPECT_TRUE(stage_.isContinuedBy(111 * kTenth));
  EXPECT_FALSE(stage_.isContinuedBy(112 * kTenth));
  EXPECT_FALSE(stage_.isContinuedBy(101 * kTenth));
  ASSERT_TRUE(add(152 * kTenth, picture(3)));
  EXPECT_TRUE(stage_.isContinuedBy(153 * kTenth));
  EXPECT_TRUE(stage_.isContinuedBy(103 * kTenth)) << "the last image alone has jumped ahead";
  EXPECT_FALSE(stage_.isContinuedBy(125 * kTenth)) << "too long after the one before";
  EXPECT_FALSE(stage_.isContinuedBy(90 * kTenth));
}

TEST_F(ImageStageTest, ADamagedLastImageIsNamed) {
  ASSERT_TRUE(next(picture(1)));
  State state;
  stage_.save(state);
  auto png = state.child("last").get<std::vector<std::uint8_t>>("png");
  for (const std::size_t size : {std::size_t{0}, std::size_t{20}}) {
    png.resize(size);
    state.child("last").set("png", png);
    try {
      stage_.load(state);
      ADD_FAILURE() << "was taken with " << size << " bytes";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "state last/png: it is no image");
    }
  }
}

TEST_F(ImageStageTest, ParametersAreChecked) {
  ImageStageParams params;
  params.time_reset = -1.0;
  EXPECT_THROW(restartWith(params), std::invalid_argument);
}

}  // namespace
}  // namespace ratslam
