// The search gives what an exhaustive one in double precision gives: winner, shift, error to the last bit,
// and none where the mean gate excludes all - on every instruction set that this processor has.
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <vector>

#include "oracle/local_view_oracle.h"
#include "ratslam/local_view/block_sad/template_matcher.h"
#include "ratslam/local_view/block_sad/view_template.h"
#include "test_data.h"

namespace ratslam {
namespace {

/// The search at every level beside the exhaustive one.
class Searches {
 public:
  explicit Searches(const LocalViewParams& params) : params_(params), exhaustive_(params) {
    for (const SimdLevel level : availableSimdLevels()) searches_.emplace_back(params, level);
  }

  void learn(const cv::Mat& image) {
    exhaustive_.add(oracle::makeTemplate(image, params_.view_template));
    for (TemplateMatcher& search : searches_) search.add(makeViewTemplate(image, params_.view_template));
  }

  /// Fails the test where the searches differ. @return the exhaustive one's result.
  std::optional<oracle::Match> compare(const cv::Mat& image) {
    const oracle::Values expected_view = oracle::makeTemplate(image, params_.view_template);
    const ViewTemplate view = makeViewTemplate(image, params_.view_template);
    EXPECT_EQ(view.values, expected_view);
    const std::optional<oracle::Match> expected = exhaustive_.best(expected_view);
    for (TemplateMatcher& search : searches_) {
      const std::optional<TemplateMatch> found = search.findBest(view);
      EXPECT_EQ(found.has_value(), expected.has_value());
      if (!found || !expected) continue;
      EXPECT_EQ(found->id, expected->id);
      EXPECT_EQ(found->shift, expected->shift);
      EXPECT_EQ(found->error, expected->error);
      const TemplateMatch compared = search.compareWith(view, expected->id);
      EXPECT_EQ(compared.shift, expected->shift);
      EXPECT_EQ(compared.error, expected->error);
    }
    return expected;
  }

  /// Runs the images through recall and learning.
  void observeAll(const std::vector<cv::Mat>& images) {
    for (const cv::Mat& image : images) {
      const std::optional<oracle::Match> match = compare(image);
      if (!match || match->error > params_.match_threshold) learn(image);
      if (testing::Test::HasFailure()) return;
    }
  }

  const TemplateMatcher& fastest() const { return searches_.back(); }
  std::size_t size() const { return exhaustive_.size(); }

 private:
  LocalViewParams params_;
  oracle::Matcher exhaustive_;
  std::vector<TemplateMatcher> searches_;
};

cv::Mat randomImage(std::mt19937& random, int columns, int rows, int type, int darkest = 0,
                    int brightest = 255) {
  cv::Mat image(rows, columns, type);
  std::uniform_int_distribution<int> value(darkest, brightest);
  for (int y = 0; y < rows; ++y) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(columns) * image.elemSize(); ++i) {
      image.ptr<std::uint8_t>(y)[i] = static_cast<std::uint8_t>(value(random));
    }
  }
  return image;
}

/// Each value moved by at most `most`.
cv::Mat withNoise(std::mt19937& random, const cv::Mat& image, int most) {
  cv::Mat noisy = image.clone();
  std::uniform_int_distribution<int> change(-most, most);
  for (int y = 0; y < noisy.rows; ++y) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(noisy.cols) * noisy.elemSize1(); ++i) {
      std::uint8_t& value = noisy.ptr<std::uint8_t>(y)[i];
      value = cv::saturate_cast<std::uint8_t>(value + change(random));
    }
  }
  return noisy;
}

struct Case {
  const char* name;
  LocalViewParams params;
  int image_type;
  double normalisation;
  int patch_radius;
};

class RandomImages : public testing::TestWithParam<Case> {};

// Images of 3 x 2 pixels a value with a remainder, new ones and noisy copies of earlier ones.
TEST_P(RandomImages, AreMatchedAsExhaustively) {
  LocalViewParams params = GetParam().params;
  params.view_template.normalisation = GetParam().normalisation;
  params.view_template.patch_radius = GetParam().patch_radius;
  Searches searches(params);
  std::mt19937 random(7);
  std::vector<cv::Mat> seen;
  for (int i = 0; i < 60; ++i) {
    const int darkest = i % 3 == 0 ? 0 : 150;
    seen.push_back(randomImage(random, params.view_template.x_size * 3 + 2,
                               params.view_template.y_size * 2 + 1, GetParam().image_type, darkest));
    searches.learn(seen.back());
  }
  for (int i = 0; i < 10; ++i) {
    searches.compare(randomImage(random, seen[0].cols, seen[0].rows, GetParam().image_type));
    if (seen[0].depth() == CV_8U)
      searches.compare(withNoise(random, seen[static_cast<std::size_t>(6 * i)], 20));
    const auto match = searches.compare(seen[static_cast<std::size_t>(5 * i)]);
    ASSERT_TRUE(match.has_value());
    const bool compares_in_place = params.panoramic || params.shift_match % params.step_match == 0;
    EXPECT_EQ(match->error == 0.0, compares_in_place);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Shapes, RandomImages,
    testing::Values(Case{"forward", smallParams(60, 10, 5, 1, false), CV_8UC1, 0, 0},
                    Case{"forward_colour_normalised", smallParams(60, 10, 5, 1, false), CV_8UC3, 0.4, 0},
                    Case{"forward_bright_target", smallParams(60, 20, 4, 1, false), CV_8UC1, 0.9, 0},
                    Case{"forward_16_bit", smallParams(60, 10, 5, 3, false), CV_16UC1, 0.4, 0},
                    Case{"forward_patches", smallParams(33, 7, 3, 2, false), CV_8UC4, 0.5, 2},
                    Case{"panoramic", smallParams(60, 10, 0, 5, true), CV_8UC1, 0, 0},
                    Case{"panoramic_patches", smallParams(60, 10, 5, 5, true), CV_8UC1, 0, 2},
                    Case{"panoramic_step_not_dividing", smallParams(37, 11, 0, 7, true), CV_8UC3, 0.4, 0},
                    Case{"many_shifts", smallParams(64, 9, 13, 1, false), CV_8UC1, 0, 0},
                    Case{"wide", smallParams(250, 3, 6, 1, false), CV_8UC1, 0, 0},
                    Case{"very_wide", smallParams(300, 3, 6, 1, false), CV_8UC1, 0, 0},
                    Case{"odd", smallParams(13, 3, 2, 1, false), CV_8UC1, 0, 0},
                    Case{"one_row", smallParams(21, 1, 10, 1, false), CV_8UC1, 0, 0},
                    Case{"one_column", smallParams(1, 17, 0, 1, false), CV_8UC1, 0, 0},
                    Case{"one_value", smallParams(1, 1, 0, 1, false), CV_8UC1, 0, 0},
                    Case{"one_value_panoramic", smallParams(1, 1, 25, 5, true), CV_16UC1, 0, 0}),
    [](const auto& tested) { return tested.param.name; });

TEST(Search, TakesTheLowestIdAmongEqualTemplates) {
  Searches searches(smallParams(12, 4, 2, 1, false));
  std::mt19937 random(3);
  const cv::Mat place = randomImage(random, 24, 8, CV_8UC1);
  for (int i = 0; i < 30; ++i) searches.learn(place);
  const auto same = searches.compare(place);
  ASSERT_TRUE(same.has_value());
  EXPECT_EQ(same->id, 0U);
  EXPECT_EQ(same->shift, 2);
  const auto similar = searches.compare(withNoise(random, place, 9));
  ASSERT_TRUE(similar.has_value());
  EXPECT_EQ(similar->id, 0U);
}

TEST(Search, TakesTheLowestShiftAmongEqualOnes) {
  for (const bool panoramic : {false, true}) {
    for (const int value : {0, 77, 255}) {
      Searches searches(smallParams(12, 4, 2, 1, panoramic));
      const cv::Mat plain(8, 24, CV_8UC1, cv::Scalar(value));
      for (int i = 0; i < 9; ++i) searches.learn(plain);
      const auto match = searches.compare(plain);
      ASSERT_TRUE(match.has_value());
      EXPECT_EQ(match->id, 0U);
      EXPECT_EQ(match->shift, 0);
      EXPECT_EQ(match->error, 0.0);
    }
  }
}

TEST(Search, FindsNothingWhereTheMeanGateExcludesAll) {
  Searches searches(smallParams(12, 4, 2, 1, false));
  const cv::Mat black(8, 24, CV_8UC1, cv::Scalar(0));
  EXPECT_FALSE(searches.compare(black).has_value());
  for (int i = 0; i < 20; ++i) searches.learn(black);
  EXPECT_FALSE(searches.compare(cv::Mat(8, 24, CV_8UC1, cv::Scalar(255))).has_value());
  EXPECT_TRUE(searches.compare(cv::Mat(8, 24, CV_8UC1, cv::Scalar(40))).has_value());
}

TEST(Search, ReportsErrorsUpToOne) {
  LocalViewParams params = smallParams(12, 4, 2, 1, false);
  params.match_threshold = 1.0;
  Searches searches(params);
  for (int i = 0; i < 9; ++i) searches.learn(cv::Mat(8, 24, CV_8UC1, cv::Scalar(255)));
  const auto match = searches.compare(cv::Mat(8, 24, CV_8UC1, cv::Scalar(0)));
  ASSERT_TRUE(match.has_value());
  EXPECT_EQ(match->error, 1.0);
}

// Bounds exclude nearly every random template, and nearly none of many copies of one place: views of either
// kind, met with the templates of one kind, then the other, and with both by turns.
TEST(Search, TakesTemplatesOfChangingCharacter) {
  constexpr int kTemplates = 300;
  const std::vector<std::function<bool(int)>> orders{
      [](int i) { return i < kTemplates / 2; }, [](int i) { return i >= kTemplates / 2; },
      [](int i) { return i % 2 == 0; }, [](int i) { return i / 24 % 2 == 0; }};
  for (const auto& similar : orders) {
    LocalViewParams params = smallParams(60, 10, 5, 1, false);
    params.match_threshold = 1.0;  // no gate of means
    Searches searches(params);
    std::mt19937 random(17);
    const cv::Mat place = randomImage(random, 60, 10, CV_8UC1, 10, 240);
    for (int i = 0; i < kTemplates; ++i) {
      searches.learn(similar(i) ? withNoise(random, place, 3) : randomImage(random, 60, 10, CV_8UC1));
    }
    for (int i = 0; i < 5; ++i) {
      searches.compare(withNoise(random, place, 3));
      searches.compare(withNoise(random, place, 60));
      searches.compare(randomImage(random, 60, 10, CV_8UC1));
    }
    searches.compare(cv::Mat(10, 60, CV_8UC1, cv::Scalar(128)));
  }
}

// Templates that differ by one grey level in one pixel of 480: far below what 8 bits tell apart.
TEST(Search, TellsApartWhatEightBitsCannot) {
  Searches searches(smallParams(60, 10, 5, 1, false));
  std::mt19937 random(11);
  const cv::Mat place = randomImage(random, 1200, 240, CV_8UC1, 10, 240);
  for (int i = 0; i < 40; ++i) {
    cv::Mat changed = place.clone();
    for (int k = 0; k < (i * 17) % 40 + 1; ++k) ++changed.at<std::uint8_t>((k * 29) % 240, 120 + k * 20);
    searches.learn(changed);
  }
  const auto match = searches.compare(place);
  ASSERT_TRUE(match.has_value());
  EXPECT_GT(match->error, 0.0);
  EXPECT_EQ(match->id, 0U);  // the one with a single pixel changed
}

// The gate is a comparison of doubles: means on both sides of it, a grey level of one pixel apart.
TEST(Search, GatesTemplatesAtExactlyTheThreshold) {
  LocalViewParams params = smallParams(10, 10, 0, 1, false);
  params.match_threshold = 0.035;
  Searches searches(params);
  cv::Mat image(10, 10, CV_8UC1, cv::Scalar(100));
  searches.learn(image);
  int found = 0;
  for (int i = 0; i < 1200; ++i) {
    ++image.at<std::uint8_t>(i / 10 % 10, i % 10);
    if (i > 900) found += searches.compare(image).has_value() ? 1 : 0;
  }
  EXPECT_EQ(found, 1020 - 901);  // 0.04 of the whole is 1020 grey levels
}

TEST(Search, RemembersValuesToTheLastBit) {
  std::mt19937 random(5);
  for (const int type : {CV_8UC1, CV_8UC3, CV_16UC1}) {
    for (const double normalisation : {0.0, 0.1, 0.95}) {
      for (const int radius : {0, 1}) {
        LocalViewParams params = smallParams(16, 9, 2, 1, false);
        params.view_template.normalisation = normalisation;
        params.view_template.patch_radius = radius;
        TemplateMatcher search(params);
        for (std::uint32_t id = 0; id < 20; ++id) {
          const ViewTemplate learned =
              makeViewTemplate(randomImage(random, 71, 29, type), params.view_template);
          ASSERT_EQ(search.add(learned), id);
          ASSERT_EQ(search.values(id), learned.values);
          ASSERT_EQ(search.bytes(id), quantised(learned.values));
        }
      }
    }
  }
}

TEST(Search, TakesImagesOfDifferentTypesTogether) {
  LocalViewParams params = smallParams(20, 6, 3, 1, false);
  params.match_threshold = 0.06;
  Searches searches(params);
  std::mt19937 random(9);
  std::vector<cv::Mat> images;
  for (int i = 0; i < 30; ++i) {
    const int type = i % 3 == 0 ? CV_8UC1 : i % 3 == 1 ? CV_8UC3 : CV_16UC1;
    images.push_back(randomImage(random, 60, 30, type, 10 * (i % 7), 90 + 20 * (i % 7)));
  }
  searches.observeAll(images);
  EXPECT_GT(searches.size(), 1U);
}

TEST(Search, RefusesTemplatesOfAnotherSize) {
  TemplateMatcher search(smallParams(20, 6, 3, 1, false));
  const ViewTemplate other = makeViewTemplate(cv::Mat(30, 60, CV_8UC1, cv::Scalar(9)),
                                              smallParams(10, 6, 3, 1, false).view_template);
  EXPECT_THROW(search.add(other), std::invalid_argument);
  EXPECT_THROW(search.findBest(other), std::invalid_argument);
  EXPECT_THROW(search.values(0), std::out_of_range);
}

std::vector<cv::Mat> imagesIn(const std::filesystem::path& folder, const std::string& extension, int first,
                              int step, int count) {
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_directory(folder)) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      if (entry.path().extension() == extension) files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  std::vector<cv::Mat> images;
  for (int i = 0; i < count; ++i) {
    const auto index = static_cast<std::size_t>(first + i * step);
    if (index < files.size()) images.push_back(cv::imread(files[index].string(), cv::IMREAD_UNCHANGED));
  }
  return images;
}

void compareOn(const std::vector<cv::Mat>& images, const LocalViewParams& params) {
  Searches searches(params);
  searches.observeAll(images);
  EXPECT_GT(searches.size(), 10U);
}

TEST(SearchOnRealImages, KittiThereAndBack) {
  std::vector<cv::Mat> images = imagesIn(dataFolder() / "kitti_00/image_0", ".jpg", 100, 4, 40);
  const std::vector<cv::Mat> again = imagesIn(dataFolder() / "kitti_00/image_0", ".jpg", 1550, 3, 40);
  if (images.empty()) GTEST_SKIP() << "no KITTI images in " << dataFolder();
  images.insert(images.end(), again.begin(), again.end());
  compareOn(images, forwardReference());
  compareOn(images, panoramicReference());
}

TEST(SearchOnRealImages, NordlandSummerThenWinter) {
  std::vector<cv::Mat> images = imagesIn(dataFolder() / "nordland/summer", ".png", 0, 5, 150);
  const std::vector<cv::Mat> winter = imagesIn(dataFolder() / "nordland/winter", ".png", 0, 5, 150);
  if (images.empty()) GTEST_SKIP() << "no Nordland images in " << dataFolder();
  images.insert(images.end(), winter.begin(), winter.end());
  LocalViewParams params = smallParams(60, 10, 5, 1, false);
  params.match_threshold = 0.05;
  compareOn(images, params);
  params.view_template.normalisation = 0.5;
  compareOn(images, params);
}

TEST(SearchOnRealImages, DonkeyLaps) {
  const std::vector<cv::Mat> images = imagesIn(dataFolder() / "donkey_lab_laps/images", ".jpg", 0, 12, 300);
  if (images.empty()) GTEST_SKIP() << "no donkey car images in " << dataFolder();
  LocalViewParams params = smallParams(32, 24, 4, 1, false);
  params.match_threshold = 0.08;
  compareOn(images, params);
}

// 60 x 10 values of 20 x 24 pixels need 17 bits each to be exact, 18 where they are scaled down: 1350 bytes
// before the means of blocks, filled up rows and bookkeeping. Where a value is one pixel, its 8
// bits are exact.
TEST(Search, KeepsTemplatesInLittleMemory) {
  LocalViewParams params = forwardReference();
  TemplateMatcher search(params);
  std::mt19937 random(2);
  const cv::Mat large = randomImage(random, 1241, 376, CV_8UC1, 60, 160);
  const ViewTemplate learned = makeViewTemplate(large, params.view_template);
  for (int i = 0; i < 4096; ++i) search.add(learned);
  EXPECT_LE(search.memoryBytes(), 4096U * 1520U);

  params.view_template = TemplateParams();  // one pixel a value: 8 bits are exact
  params.view_template.x_size = 60;
  params.view_template.y_size = 10;
  TemplateMatcher small(params);
  for (int i = 0; i < 4096; ++i) {
    small.add(makeViewTemplate(large(cv::Rect(i % 1000, i % 300, 60, 10)), params.view_template));
  }
  EXPECT_LE(small.memoryBytes(), 4096U * 780U);
}

TEST(ExhaustiveSearch, ATemplateIsComparedAtItsBestShift) {
  LocalViewParams params;
  params.view_template.x_size = 20;
  params.view_template.y_size = 4;
  params.panoramic = true;
  params.match_threshold = 1.0;
  std::mt19937 generator(1);
  const auto inFog = [&] {  // a few grey levels: many shifts are nearly as good
    BlockSums blocks;
    blocks.columns = 20;
    blocks.rows = 4;
    blocks.full_scale = 25500;
    for (int k = 0; k < 80; ++k) blocks.sums.push_back(5000 + generator() % 800);
    return makeViewTemplate(blocks, params.view_template);
  };
  for (int trial = 0; trial < 200; ++trial) {
    TemplateMatcher search(params);
    search.add(inFog());
    const ViewTemplate view = inFog();
    const TemplateMatch compared = search.compareWith(view, 0);
    const std::optional<TemplateMatch> best = search.findBest(view);
    ASSERT_TRUE(best);
    EXPECT_EQ(compared.shift, best->shift);
    EXPECT_EQ(compared.error, best->error);
  }
}

}  // namespace
}  // namespace ratslam
