// A learned view that another matcher learns is the same template there, to the last bit (ViewMatcher::learned).
#include <gtest/gtest.h>

#include <random>

#include "ratslam/common/state.h"
#include "ratslam/local_view/block_sad/block_sad_pair.h"
#include "test_data.h"

namespace ratslam {
namespace {

LocalViewParams normalisedParams(double normalisation, int patch_radius) {
  LocalViewParams params = smallParams(20, 6, 0, 1, false);
  params.view_template.normalisation = normalisation;
  params.view_template.patch_radius = patch_radius;
  return params;
}

/// A dark street in which some blocks are lamps.
cv::Mat streetWithLamps(double share_of_lamps, std::mt19937& random) {
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  cv::Mat image(24, 80, CV_8UC1);
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column < 20; ++column) {
      const bool lamp = chance(random) < share_of_lamps;
      const double grey = lamp ? 230.0 + 25.0 * chance(random) : 5.0 + 60.0 * chance(random);
      image(cv::Rect(4 * column, 4 * row, 4, 4)).setTo(cv::Scalar(grey));
      image.at<std::uint8_t>(4 * row, 4 * column) = static_cast<std::uint8_t>(255.0 * chance(random));
    }
  }
  return image;
}

class LearnedView : public testing::TestWithParam<std::tuple<double, int>> {};

TEST_P(LearnedView, IsTheSameTemplateToAnotherMatcher) {
  const auto [normalisation, patch_radius] = GetParam();
  const LocalViewParams params = normalisedParams(normalisation, patch_radius);
  const ViewPair first = makeBlockSadPair(params);
  const ViewPair second = makeBlockSadPair(params);
  const ViewPair third = makeBlockSadPair(params);
  std::mt19937 random(11);
  for (int k = 0; k < 60; ++k) {
    const double lamps = k % 6 * 0.2;
    const auto id = first.matcher->add(first.descriptor->describe(streetWithLamps(lamps, random)));
    second.matcher->add(first.matcher->learned(id));
    third.matcher->add(second.matcher->learned(id));
    ASSERT_EQ(second.matcher->compareWith(first.matcher->learned(id), id).error, 0.0) << lamps;
  }
  State of_first, of_second, of_third;
  first.matcher->save(of_first);
  second.matcher->save(of_second);
  third.matcher->save(of_third);
  EXPECT_TRUE(of_first.toBytes() == of_second.toBytes());
  EXPECT_TRUE(of_first.toBytes() == of_third.toBytes());
}

INSTANTIATE_TEST_SUITE_P(Normalisations, LearnedView,
                         testing::Combine(testing::Values(0.0, 0.2, 0.4, 0.7, 1.0), testing::Values(0, 2)));

TEST(LearnedBlocks, SayTheirScaleOnlyWhereTheSumsDoNotTellIt) {
  const ViewPair pair = makeBlockSadPair(normalisedParams(0.5, 0));
  std::mt19937 random(3);
  const View plain = pair.descriptor->describe(streetWithLamps(0.0, random));
  const View bright = pair.descriptor->describe(streetWithLamps(0.2, random));
  pair.matcher->add(plain);
  pair.matcher->add(bright);
  EXPECT_EQ(pair.matcher->learned(0).variants.front().values, plain.variants.front().values);
  EXPECT_EQ(pair.matcher->learned(1).variants.front().values.size(),
            bright.variants.front().values.size() + 1);
}

}  // namespace
}  // namespace ratslam
