#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <random>

#include "ratslam/common/state.h"
#include "ratslam/local_view/local_view_cells.h"
#include "ratslam/local_view/orientation/orientation_energy.h"
#include "ratslam/simd/byte_products.h"

namespace ratslam {
namespace {

/// Edges of all orientations; another one for each seed.
cv::Mat scene(unsigned seed) {
  std::mt19937 random(seed);
  cv::Mat image(64, 128, CV_8UC1, cv::Scalar(90));
  for (int i = 0; i < 25; ++i) {
    const auto next = [&random](int limit) {
      return static_cast<int>(random() % static_cast<unsigned>(limit));
    };
    cv::line(image, {next(128), next(64)}, {next(128), next(64)}, cv::Scalar(next(256)), 1 + next(6));
  }
  return image;
}

LocalViewParams params(const char* recall) {
  LocalViewParams chosen;
  chosen.descriptor = "orientation";
  chosen.recall.kind = recall;
  return chosen;
}

TEST(ByteProducts, AreTheSameAtEveryLevel) {
  constexpr std::size_t kLength = 1152;
  constexpr std::size_t kCount = 9;
  constexpr std::size_t kQueries = 7;
  std::mt19937 random(3);
  std::vector<std::uint8_t> vectors(kCount * kLength);
  std::vector<std::int8_t> queries(kQueries * kLength);
  for (auto& byte : vectors) byte = static_cast<std::uint8_t>(random() % 255 + 1);
  for (auto& byte : queries) byte = static_cast<std::int8_t>(static_cast<int>(random() % 255) - 127);
  std::vector<std::int32_t> expected;
  for (const SimdLevel level : availableSimdLevels()) {
    std::vector<std::int32_t> products(kQueries * kCount);
    byteProductsFor(level)(vectors.data(), kCount, kLength, queries.data(), kQueries, products.data(),
                           kCount);
    if (expected.empty()) expected = products;
    EXPECT_EQ(products, expected);
  }
}

TEST(OrientationEnergy, HardlyKnowsTheLight) {
  const cv::Mat bright = scene(1);
  cv::Mat dark;
  bright.convertTo(dark, CV_8UC1, 0.5, 10);
  const auto a = OrientationEnergy(bright, TemplateParams{}, false).values(0);
  const auto b = OrientationEnergy(dark, TemplateParams{}, false).values(0);
  const auto other = OrientationEnergy(scene(2), TemplateParams{}, false).values(0);
  double change = 0.0;
  double difference = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    change += std::abs(a[i] - b[i]);
    difference += std::abs(a[i] - other[i]);
  }
  EXPECT_LT(change, 0.15 * difference);
}

TEST(OrientationEnergy, OfAPanoramaTurnsWithIt) {
  const cv::Mat image = scene(4);
  cv::Mat turned;
  cv::hconcat(image.colRange(96, 128), image.colRange(0, 96), turned);  // by 16 of 64 columns to the right
  const auto moved = OrientationEnergy(image, TemplateParams{}, true).values(16);
  EXPECT_EQ(moved, OrientationEnergy(turned, TemplateParams{}, true).values(0));
}

/// Drives `first`..`last` of a row of scenes. @return the events
std::vector<ViewEvent> drive(LocalViewCells& cells, unsigned first, unsigned last, double gain) {
  std::vector<ViewEvent> events;
  for (unsigned i = first; i < last; ++i) {
    cv::Mat image;
    scene(i).convertTo(image, CV_8UC1, gain, 0);
    events.push_back(cells.observe(static_cast<Stamp>(i), image));
  }
  return events;
}

TEST(Belief, RecallsARouteInAnotherLightAndLearnsWhatFollows) {
  LocalViewCells cells(params("belief"));
  for (const ViewEvent& event : drive(cells, 0, 100, 1.0)) EXPECT_TRUE(event.learned);
  const std::vector<ViewEvent> again = drive(cells, 20, 60, 0.5);
  std::size_t recalled = 0;
  for (std::size_t i = 0; i < again.size(); ++i) {
    if (again[i].learned) continue;
    ++recalled;
    EXPECT_EQ(again[i].id, 20 + i);
  }
  EXPECT_GE(recalled, 30U);
  std::size_t learned = 0;
  for (const ViewEvent& event : drive(cells, 1000, 1030, 0.5)) learned += event.learned ? 1 : 0;
  EXPECT_GE(learned, 27U);  // ways are rarely left: it takes a few views to believe it
}

TEST(Belief, StandsStillWhereItStoodStill) {
  LocalViewCells cells(params("belief"));
  const auto pass = [&cells](unsigned last, double gain) {
    std::vector<ViewEvent> events = drive(cells, 0, 60, gain);
    for (int i = 0; i < 30; ++i) events.push_back(drive(cells, 60, 61, gain).front());
    for (const ViewEvent& event : drive(cells, 61, last, gain)) events.push_back(event);
    return events;
  };
  pass(100, 1.0);
  ASSERT_EQ(cells.size(), 100U);
  const std::vector<ViewEvent> again = pass(90, 0.5);
  int recalled = 0;
  for (std::size_t i = 60; i < 90; ++i) recalled += again[i].id == 60 ? 1 : 0;
  EXPECT_EQ(recalled, 30);
  EXPECT_EQ(again.back().id, 89U);
}

TEST(Belief, IsContinuedToTheSameBits) {
  LocalViewCells whole(params("belief"));
  LocalViewCells continued(params("belief"));
  drive(whole, 0, 80, 1.0);
  State state;
  whole.save(state);
  continued.load(State::fromBytes(state.toBytes()));
  const auto a = drive(whole, 10, 40, 0.7);
  const auto b = drive(continued, 10, 40, 0.7);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].id, b[i].id);
    EXPECT_EQ(a[i].error, b[i].error);
  }
  State of_whole;
  State of_continued;
  whole.save(of_whole);
  continued.save(of_continued);
  EXPECT_TRUE(of_whole == of_continued);
}

ViewMotion ahead(double metres) {
  ViewMotion motion;
  motion.forward = metres;
  return motion;
}

TEST(Belief, TellsIdenticalHousesInARowApartByOdometry) {
  LocalViewCells cells(params("belief"));
  for (unsigned i = 0; i < 200; ++i) {
    const cv::Mat image = scene(i < 20 ? i : 20 + i % 12);  // after 20 places the same house every 12 m
    const auto event = cells.observe(i, cells.describe(image), image, ahead(1.0));
    EXPECT_TRUE(event.learned) << i << " taken for " << event.id;
  }
}

}  // namespace
}  // namespace ratslam
