#include "ratslam/local_view/local_view_cells.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <random>
#include <string>
#include <vector>

#include "ratslam/common/angles.h"
#include "ratslam/local_view/orientation/byte_matcher.h"
#include "unit/message_of.h"

namespace ratslam {
namespace {

LocalViewParams smallParams() {
  LocalViewParams params;
  params.view_template.x_size = 16;
  params.view_template.y_size = 8;
  params.match_threshold = 0.05;
  params.shift_match = 2;
  params.step_match = 1;
  return params;
}

/// Places that look different from each other.
std::vector<cv::Mat> places(int count) {
  std::mt19937 random(1);
  std::uniform_int_distribution<int> value(0, 255);
  std::vector<cv::Mat> images;
  for (int i = 0; i < count; ++i) {
    images.emplace_back(24, 48, CV_8UC1);
    for (auto it = images.back().begin<std::uint8_t>(); it != images.back().end<std::uint8_t>(); ++it) {
      *it = static_cast<std::uint8_t>(value(random) / 2);
    }
    // Blocks of their own brightness: 3 x 3 pixels of noise alone would average out.
    for (int y = 0; y < 24; y += 3) {
      for (int x = 0; x < 48; x += 3) images.back()(cv::Rect(x, y, 3, 3)) += cv::Scalar(value(random) / 2);
    }
  }
  return images;
}

TEST(LocalViewCells, LearnsNewViewsAndRecallsKnownOnes) {
  LocalViewCells cells(smallParams());
  const std::vector<cv::Mat> images = places(5);
  for (std::uint32_t i = 0; i < 5; ++i) {
    const ViewEvent event = cells.observe(10 + i, images[i]);
    EXPECT_EQ(event.stamp, 10 + i);
    EXPECT_EQ(event.id, i);
    EXPECT_TRUE(event.learned);
    EXPECT_EQ(event.relative_rad, 0.0);
    EXPECT_EQ(event.error < 0.0, i == 0);  // nothing to compare the first with
  }
  const ViewEvent again = cells.observe(99, images[3]);
  EXPECT_EQ(again.id, 3U);
  EXPECT_FALSE(again.learned);
  EXPECT_EQ(again.error, 0.0);
  EXPECT_EQ(cells.size(), 5U);
}

TEST(LocalViewCells, RecallsAtExactlyTheThreshold) {
  LocalViewParams params = smallParams();
  cv::Mat image(24, 48, CV_8UC1, cv::Scalar(100));
  cv::Mat brighter(24, 48, CV_8UC1, cv::Scalar(105));
  // Something to see, at the edge, which no view without a shift compares.
  for (cv::Mat* seen : {&image, &brighter}) (*seen)(cv::Rect(0, 0, 3, 3)) = cv::Scalar(0);
  LocalViewCells probe(params);
  probe.observe(0, image);
  const double error = probe.observe(1, brighter).error;
  EXPECT_NEAR(error, 5.0 / 255.0, 1e-12);

  params.match_threshold = error;
  LocalViewCells at_threshold(params);
  at_threshold.observe(0, image);
  EXPECT_FALSE(at_threshold.observe(1, brighter).learned);

  params.match_threshold = std::nextafter(error, 0.0);
  LocalViewCells below(params);
  below.observe(0, image);
  const ViewEvent event = below.observe(1, brighter);
  EXPECT_TRUE(event.learned);
  EXPECT_EQ(event.error, error);  // the best candidate's, although it was not recalled
}

TEST(LocalViewCells, TurnsAPanoramaIntoARelativeHeading) {
  LocalViewParams params = smallParams();
  params.panoramic = true;
  params.step_match = 4;
  LocalViewCells cells(params);
  const cv::Mat image = places(1)[0];
  cells.observe(0, image);
  cv::Mat twice;
  cv::hconcat(image, image, twice);
  for (int quarter = 0; quarter < 4; ++quarter) {
    const ViewEvent event = cells.observe(1, twice.colRange(12 * quarter, 12 * quarter + 48));
    EXPECT_EQ(event.id, 0U);
    EXPECT_NEAR(event.error, 0.0, 1e-15);
    const double expected[] = {0.0, kPi / 2, kPi, -kPi / 2};
    EXPECT_NEAR(event.relative_rad, expected[quarter], 1e-12);
  }
}

struct FakeVerifier : RecallVerifier {
  std::optional<RecallGeometry> verify(Stamp stamp, const cv::Mat&, std::uint32_t view_id) override {
    asked.push_back(view_id);
    if (!confirms) return std::nullopt;
    RecallGeometry geometry;
    geometry.stamp = stamp;
    geometry.view_id = view_id;
    geometry.relative_rad = 0.25;
    geometry.inliers = inliers;
    return geometry;
  }
  void learned(Stamp, const cv::Mat&, std::uint32_t view_id) override { told.push_back(view_id); }

  bool confirms = true;
  int inliers = 40;
  std::vector<std::uint32_t> asked;
  std::vector<std::uint32_t> told;
};

TEST(LocalViewCells, AsksTheVerifierAboutOldViewsOnly) {
  LocalViewCells cells(smallParams());
  const std::vector<cv::Mat> images = places(15);
  FakeVerifier verifier;
  for (const cv::Mat& image : images) cells.observe(0, image, &verifier);
  EXPECT_EQ(verifier.told.size(), 15U);
  EXPECT_TRUE(verifier.asked.empty());

  cells.observe(1, images[5], &verifier);  // one of the last 10
  EXPECT_TRUE(verifier.asked.empty());
  EXPECT_FALSE(cells.recallGeometry().has_value());

  const ViewEvent recall = cells.observe(2, images[4], &verifier);
  EXPECT_EQ(verifier.asked, std::vector<std::uint32_t>{4});
  EXPECT_EQ(recall.id, 4U);
  EXPECT_FALSE(recall.learned);
  EXPECT_EQ(recall.relative_rad, 0.25);
  ASSERT_TRUE(cells.recallGeometry().has_value());
  EXPECT_EQ(cells.recallGeometry()->view_id, 4U);

  cells.observe(3, images[4], &verifier);  // still there
  EXPECT_EQ(verifier.asked.size(), 1U);
  EXPECT_FALSE(cells.recallGeometry().has_value());
  EXPECT_EQ(verifier.told.size(), 15U);
}

TEST(LocalViewCells, AsksTheVerifierAboutAllViewsFromBeforeItWokeUp) {
  LocalViewCells cells(smallParams());
  const std::vector<cv::Mat> images = places(15);
  FakeVerifier verifier;
  for (const cv::Mat& image : images) cells.observe(0, image, &verifier);
  cells.wakeUp();
  cells.observe(1, images[14], &verifier);  // the last one, and one of the last 10
  cells.observe(2, images[12], &verifier);
  EXPECT_EQ(verifier.asked, (std::vector<std::uint32_t>{14, 12}));
  cells.observe(3, images[12], &verifier);  // still there
  EXPECT_EQ(verifier.asked.size(), 2U);
}

TEST(LocalViewCells, ARecallOfWhichNothingCanBeSaidStands) {
  LocalViewCells cells(smallParams());
  const std::vector<cv::Mat> images = places(15);
  FakeVerifier verifier;
  verifier.inliers = 0;
  for (const cv::Mat& image : images) cells.observe(0, image, &verifier);
  const ViewEvent recall = cells.observe(2, images[4], &verifier);
  EXPECT_EQ(recall.id, 4U);
  EXPECT_EQ(recall.relative_rad, 0.0);
  EXPECT_FALSE(cells.recallGeometry().has_value());
}

TEST(LocalViewCells, LearnsWhatTheVerifierDoesNotConfirm) {
  LocalViewCells cells(smallParams());
  const std::vector<cv::Mat> images = places(15);
  FakeVerifier verifier;
  for (const cv::Mat& image : images) cells.observe(0, image, &verifier);
  verifier.confirms = false;
  const ViewEvent event = cells.observe(1, images[2], &verifier);
  EXPECT_EQ(verifier.asked, std::vector<std::uint32_t>{2});
  EXPECT_TRUE(event.learned);
  EXPECT_EQ(event.id, 15U);
  EXPECT_EQ(event.error, 0.0);
  EXPECT_EQ(event.relative_rad, 0.0);
  EXPECT_EQ(verifier.told.back(), 15U);
  EXPECT_FALSE(cells.recallGeometry().has_value());
}

TEST(LocalViewCells, RefusesAnotherImageSizeAndGoesOn) {
  LocalViewCells cells(smallParams());
  const std::vector<cv::Mat> images = places(2);
  cells.observe(0, images[0]);
  const std::string message = test::messageOf<std::invalid_argument>(
      [&] { cells.observe(1, cv::Mat(30, 48, CV_8UC1, cv::Scalar(0))); });
  EXPECT_NE(message.find("48 x 24"), std::string::npos) << message;
  EXPECT_NE(message.find("48 x 30"), std::string::npos) << message;
  EXPECT_THROW(cells.observe(1, cv::Mat()), std::invalid_argument);
  EXPECT_THROW(cells.observe(1, cv::Mat(24, 48, CV_32FC1, cv::Scalar(0))), std::invalid_argument);
  EXPECT_EQ(cells.size(), 1U);
  EXPECT_FALSE(cells.observe(2, images[0]).learned);
}

TEST(LocalViewCells, NamesTheParameterThatDoesNotFitTheImage) {
  const cv::Mat image(24, 48, CV_8UC1, cv::Scalar(9));
  const auto message_for = [&](const std::function<void(TemplateParams&)>& change) {
    LocalViewParams params = smallParams();
    change(params.view_template);
    LocalViewCells cells(params);
    const std::string message = test::messageOf<std::invalid_argument>([&] { cells.observe(0, image); });
    EXPECT_EQ(cells.size(), 0U);
    EXPECT_NE(message.find("48 x 24"), std::string::npos) << message;
    return message;
  };
  EXPECT_EQ(message_for([](TemplateParams& p) { p.crop_x_max = 49; }).find("image_crop_x_max: value 49 "),
            0U);
  EXPECT_EQ(message_for([](TemplateParams& p) { p.crop_y_max = 25; }).find("image_crop_y_max: value 25 "),
            0U);
  EXPECT_EQ(message_for([](TemplateParams& p) { p.crop_x_min = 48; }).find("image_crop_x_min: value 48 "),
            0U);
  EXPECT_EQ(message_for([](TemplateParams& p) { p.crop_y_min = 30; }).find("image_crop_y_min: value 30 "),
            0U);
  EXPECT_EQ(message_for([](TemplateParams& p) { p.crop_x_min = 40; }).find("template_x_size: value 16 "), 0U);
  EXPECT_EQ(message_for([](TemplateParams& p) { p.y_size = 25; }).find("template_y_size: value 25 "), 0U);
}

TEST(LocalViewCells, RefusesBadParameters) {
  const auto message_for = [&](const std::function<void(LocalViewParams&)>& change) {
    LocalViewParams params = smallParams();
    change(params);
    return test::messageOf<std::invalid_argument>([&] { LocalViewCells cells(params); });
  };
  EXPECT_EQ(message_for([](auto& p) { p.match_threshold = NAN; }).find("vt_match_threshold: value nan "), 0U);
  EXPECT_EQ(message_for([](auto& p) { p.step_match = 0; }).find("vt_step_match: value 0 "), 0U);
  EXPECT_EQ(message_for([](auto& p) { p.shift_match = 8; }).find("vt_shift_match: value 8 "), 0U);
  EXPECT_EQ(message_for([](auto& p) { p.view_template.x_size = 0; }).find("template_x_size: value 0 "), 0U);
  EXPECT_EQ(message_for([](auto& p) {
              p.view_template.crop_y_min = 20;
              p.view_template.crop_y_max = 20;
            }).find("image_crop_y_max: value 20 "),
            0U);
}

TEST(LocalViewCells, ShowsTemplatesAndTheView) {
  LocalViewCells cells(smallParams());
  EXPECT_TRUE(cells.viewImage().empty());
  cv::Mat image(24, 48, CV_8UC1, cv::Scalar(40));
  image.colRange(0, 3) = cv::Scalar(200);
  cells.observe(0, image);
  cv::Mat next(24, 48, CV_8UC1, cv::Scalar(44));
  next.colRange(45, 48) = cv::Scalar(200);
  cells.observe(1, next);
  ASSERT_EQ(cells.templateImage(0).size(), cv::Size(16, 8));
  EXPECT_EQ(cells.templateImage(0).at<std::uint8_t>(7, 0), 200);
  EXPECT_EQ(cells.templateImage(0).at<std::uint8_t>(7, 1), 40);
  EXPECT_EQ(cells.viewImage().at<std::uint8_t>(0, 0), 44);
  EXPECT_THROW(cells.templateImage(static_cast<std::uint32_t>(cells.size())), std::out_of_range);
}

TEST(LocalViewCells, GiveTheirViewsToOthersAsTheyWere) {
  for (const char* descriptor : {"blocks", "orientation"}) {
    LocalViewParams params = smallParams();
    params.descriptor = descriptor;
    params.view_template.normalisation = 0.4;
    LocalViewCells ours(params);
    LocalViewCells others(params);
    std::vector<cv::Mat> images = places(4);
    for (cv::Mat& image : images) cv::resize(image, image, {}, 4.0, 4.0, cv::INTER_NEAREST);
    for (std::uint32_t i = 0; i < 4; ++i) {
      ours.observe(i, images[i]);
      ASSERT_EQ(ours.size(), i + 1) << descriptor;
      EXPECT_TRUE(others.observe(i, ours.learned(i), cv::Mat(), ViewMotion{}).learned) << descriptor;
    }
    for (std::uint32_t i = 0; i < 4; ++i) {
      const ViewEvent recalled = others.observe(10 + i, images[i]);
      EXPECT_EQ(recalled.id, i) << descriptor;
      EXPECT_FALSE(recalled.learned) << descriptor;
      EXPECT_NEAR(recalled.error, 0.0, 1e-3) << descriptor;
    }
  }
}

TEST(LocalViewCells, NeitherLearnsNorRecallsWhatShowsNothing) {
  for (const char* descriptor : {"blocks", "orientation"}) {
    LocalViewParams params = smallParams();
    params.descriptor = descriptor;
    LocalViewCells cells(params);
    const cv::Size size(128, 64);
    cv::Mat scene(size, CV_8UC1);
    cv::randu(scene, 0, 255);
    EXPECT_FALSE(cells.observe(0, cv::Mat(size, CV_8UC1, cv::Scalar(3))).seen()) << descriptor;
    EXPECT_TRUE(cells.observe(1, scene).learned) << descriptor;
    EXPECT_FALSE(cells.observe(2, cv::Mat(size, CV_8UC1, cv::Scalar(252))).seen()) << descriptor;
    EXPECT_FALSE(cells.observe(3, scene).learned) << descriptor;
    EXPECT_EQ(cells.size(), 1U) << descriptor;
  }
}

/// A descriptor of one number, the mean grey, searched as bytes.
class MeanGrey : public ViewDescriptor {
 public:
  View describe(const cv::Mat& image) override {
    return {{{{1.0, cv::mean(image)[0] / 64.0 - 2.0}, 0.0}}, true};
  }
};

TEST(LocalViewCells, TakeADescriptorOfSomebodyElse) {
  DescriptorRegistry registry = DescriptorRegistry::builtIn();
  registry.add("mean_grey", [](const LocalViewParams&) {
    const auto painter = [](const std::vector<std::int8_t>&) {
      return cv::Mat(1, 1, CV_8UC1, cv::Scalar(0));
    };
    return ViewPair{std::make_unique<MeanGrey>(), std::make_unique<ByteMatcher>(2, 0.01, painter)};
  });
  LocalViewParams params;
  params.descriptor = "mean_grey";
  LocalViewCells cells(params, registry);
  EXPECT_TRUE(cells.observe(0, cv::Mat(8, 8, CV_8UC1, cv::Scalar(40))).learned);
  EXPECT_TRUE(cells.observe(1, cv::Mat(8, 8, CV_8UC1, cv::Scalar(200))).learned);
  EXPECT_EQ(cells.observe(2, cv::Mat(8, 8, CV_8UC1, cv::Scalar(41))).id, 0U);
  EXPECT_EQ(test::messageOf<std::invalid_argument>([&] { LocalViewCells unknown(params); }),
            "vt_descriptor: value mean_grey is not allowed: it must be blocks or orientation");
}

}  // namespace
}  // namespace ratslam
