#include "ratslam/local_view/recall/recall_geometry_estimator.h"

#include <gtest/gtest.h>

#include <array>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <thread>
#include <tuple>
#include <vector>

#include "ratslam/common/angles.h"
#include "unit/recall/recall_scene.h"

namespace ratslam {
namespace {

constexpr Stamp kTenth = 100000000;
constexpr int kApproach = 4;       // images before the template's
constexpr double kStep = 0.5;      // between them [m]
constexpr double kBaseline = 1.5;  // of the companion, three images before
constexpr Stamp kLater = 1000 * kTenth;

RecallGeometryParams params() {
  RecallGeometryParams p;
  p.verify = "orb";
  return p;
}

const RecallScene& street() {
  static const RecallScene scene(7);
  return scene;
}

/// What a drive up to the origin sees, the view at the origin last.
std::vector<cv::Mat> approachToOrigin(const RecallScene& scene, int steps) {
  std::vector<cv::Mat> images;
  for (int i = steps; i >= 0; --i) images.push_back(scene.view(-kStep * i, 0.0, 0.0));
  return images;
}

/// Sees the images one after the other and learns the last as template 5.
RecallGeometryEstimator learnedFrom(const std::vector<cv::Mat>& images) {
  RecallGeometryEstimator estimator(params(), RecallScene::camera());
  const Stamp first = (kApproach + 1 - static_cast<Stamp>(images.size())) * kTenth;
  for (std::size_t i = 0; i < images.size(); ++i) {
    estimator.frame(first + static_cast<Stamp>(i) * kTenth, images[i]);
  }
  estimator.learned(kApproach * kTenth, images.back(), 5);
  return estimator;
}

RecallGeometryEstimator learnedAtOrigin(const RecallScene& scene, int approach = kApproach) {
  return learnedFrom(approachToOrigin(scene, approach));
}

struct Place {
  double forward;
  double left;
  double heading_deg;
};

class Offset : public ::testing::TestWithParam<Place> {};

TEST_P(Offset, IsMeasuredWithThreeViews) {
  const Place place = GetParam();
  RecallGeometryEstimator estimator = learnedAtOrigin(street());
  const double heading = degreesToRadians(place.heading_deg);
  const auto geometry = estimator.verify(kLater, street().view(place.forward, place.left, heading), 5);
  ASSERT_TRUE(geometry.has_value());
  EXPECT_GE(geometry->inliers, params().min_inliers);
  EXPECT_EQ(geometry->view_id, 5U);
  EXPECT_EQ(geometry->stamp, kLater);
  EXPECT_EQ(geometry->template_stamp, kApproach * kTenth);
  EXPECT_EQ(geometry->companion_stamp, (kApproach - 3) * kTenth);
  EXPECT_LT(geometry->distance, 0.0);

  EXPECT_NEAR(geometry->relative_rad, heading, degreesToRadians(0.3));
  const double x = geometry->distance_ratio * kBaseline * std::cos(geometry->direction_rad);
  const double y = geometry->distance_ratio * kBaseline * std::sin(geometry->direction_rad);
  EXPECT_NEAR(x, place.forward, 0.05);
  EXPECT_NEAR(y, place.left, 0.05);
  EXPECT_GT(geometry->sigma_rotation, 0.0);
  EXPECT_LT(geometry->sigma_rotation, degreesToRadians(0.5));
  EXPECT_GT(geometry->sigma_ratio, 0.0);
  EXPECT_LT(geometry->sigma_ratio, 0.1);
}
INSTANTIATE_TEST_SUITE_P(Places, Offset,
                         ::testing::Values(Place{0.8, 0.0, 0.0}, Place{-1.0, 0.3, 0.0}, Place{0.2, 0.9, 4.0},
                                           Place{0.3, -1.0, -8.0}, Place{0.0, 0.6, 18.0},
                                           Place{0.1, -0.5, -25.0}));

class Direction : public ::testing::TestWithParam<Place> {};

TEST_P(Direction, IsMeasuredWithoutCompanion) {
  const Place place = GetParam();
  RecallGeometryEstimator estimator = learnedAtOrigin(street(), 0);
  const double heading = degreesToRadians(place.heading_deg);
  const auto geometry = estimator.verify(kLater, street().view(place.forward, place.left, heading), 5);
  ASSERT_TRUE(geometry.has_value());
  EXPECT_EQ(geometry->companion_stamp, geometry->template_stamp);
  EXPECT_LT(geometry->distance_ratio, 0.0);
  EXPECT_NEAR(geometry->relative_rad, heading, degreesToRadians(0.5));
  EXPECT_NEAR(wrapAngle(geometry->direction_rad - std::atan2(place.left, place.forward)), 0.0, 0.1);
  EXPECT_LT(geometry->sigma_direction, 0.1);
}
INSTANTIATE_TEST_SUITE_P(Places, Direction,
                         ::testing::Values(Place{1.5, 0.0, 0.0}, Place{-1.5, 0.3, 3.0},
                                           Place{0.5, 1.2, -5.0}));

TEST(RecallGeometryEstimator, TheSameImageHasNoOffsetAndNoDirection) {
  RecallGeometryEstimator estimator = learnedAtOrigin(street());
  const auto geometry = estimator.verify(kLater, street().view(0.0, 0.0, 0.0), 5);
  ASSERT_TRUE(geometry.has_value());
  EXPECT_NEAR(geometry->relative_rad, 0.0, 1e-3);
  EXPECT_NEAR(geometry->distance_ratio, 0.0, 5e-3);
  EXPECT_GT(geometry->sigma_direction, 0.3);
}

TEST(RecallGeometryEstimator, PureRotationHasAHeadingAndNoOffset) {
  for (const double degrees : {-12.0, 9.0}) {
    const cv::Mat turned = street().view(0.0, 0.0, degreesToRadians(degrees));
    RecallGeometryEstimator with_companion = learnedAtOrigin(street());
    const auto three = with_companion.verify(kLater, turned, 5);
    ASSERT_TRUE(three.has_value());
    EXPECT_NEAR(three->relative_rad, degreesToRadians(degrees), degreesToRadians(0.15));
    EXPECT_LT(three->distance_ratio, 0.02);

    RecallGeometryEstimator alone = learnedAtOrigin(street(), 0);
    const auto two = alone.verify(kLater, turned, 5);
    ASSERT_TRUE(two.has_value());
    EXPECT_NEAR(two->relative_rad, degreesToRadians(degrees), degreesToRadians(0.15));
    EXPECT_EQ(two->sigma_direction, kPi);
    EXPECT_LT(two->distance_ratio, 0.0);
  }
}

TEST(RecallGeometryEstimator, ACompanionWithoutParallaxIsNone) {
  RecallGeometryEstimator estimator(params(), RecallScene::camera());
  for (int i = 0; i < 15; ++i) estimator.frame(i * kTenth, street().view(0.0, 0.0, 0.02 * i));
  estimator.learned(15 * kTenth, street().view(0.0, 0.0, 0.3), 5);
  const auto geometry = estimator.verify(kLater, street().view(0.8, 0.0, 0.3), 5);
  ASSERT_TRUE(geometry.has_value());
  EXPECT_EQ(geometry->companion_stamp, geometry->template_stamp);
}

TEST(RecallGeometryEstimator, AFlatSceneIsNoSpecialCase) {
  const RecallScene wall(3, true);
  RecallGeometryEstimator estimator = learnedAtOrigin(wall);
  const auto geometry = estimator.verify(kLater, wall.view(0.7, 0.4, degreesToRadians(-5.0)), 5);
  ASSERT_TRUE(geometry.has_value());
  EXPECT_NEAR(geometry->relative_rad, degreesToRadians(-5.0), degreesToRadians(0.5));
  EXPECT_NEAR(geometry->direction_rad, std::atan2(0.4, 0.7), 0.15);
  EXPECT_NEAR(geometry->distance_ratio * kBaseline, std::hypot(0.4, 0.7), 0.1);
}

TEST(RecallGeometryEstimator, RejectsAnotherPlaceAndABlankImage) {
  RecallGeometryEstimator estimator = learnedAtOrigin(street());
  EXPECT_FALSE(estimator.verify(kLater, RecallScene(100).view(0.0, 0.0, 0.0), 5).has_value());
  EXPECT_FALSE(estimator.verify(kLater + 1, cv::Mat(240, 640, CV_8U, cv::Scalar(90)), 5).has_value());
  RecallGeometryEstimator alone = learnedAtOrigin(street(), 0);
  EXPECT_FALSE(alone.verify(kLater, RecallScene(100).view(0.0, 0.0, 0.0), 5).has_value());
}

TEST(RecallGeometryEstimator, KnowsNothingOfATemplateThatShowsTooLittle) {
  RecallGeometryEstimator estimator(params(), RecallScene::camera());
  cv::Mat image(240, 640, CV_8U, cv::Scalar(90));
  cv::rectangle(image, {300, 100, 30, 30}, cv::Scalar(200), -1);
  estimator.learned(0, image, 1);
  for (const cv::Mat& now : {image, street().view(0.0, 0.0, 0.0)}) {
    const auto geometry = estimator.verify(kLater, now, 1);
    ASSERT_TRUE(geometry.has_value());
    EXPECT_EQ(geometry->inliers, 0);
    EXPECT_EQ(geometry->sigma_rotation, kPi);
    EXPECT_EQ(geometry->sigma_direction, kPi);
    EXPECT_LT(geometry->distance_ratio, 0.0);
  }
}

TEST(RecallGeometryEstimator, MemoryIsBoundedAndDroppedTemplatesAreUnknown) {
  RecallGeometryParams p = params();
  p.max_templates = 6;
  p.features = 100;
  RecallGeometryEstimator estimator(p, RecallScene::camera());
  const cv::Mat image = street().view(0.0, 0.0, 0.0);
  for (std::uint32_t id = 0; id < 24; ++id) {
    estimator.learned(id * kTenth, image, id);
    EXPECT_LE(estimator.templates(), 6U);
    EXPECT_LE(estimator.memoryBytes(), 6U * (60U * 100U + 1000U)) << "60 bytes per feature and a kilobyte";
  }
  std::set<std::uint32_t> kept;
  for (std::uint32_t id = 0; id < 24; ++id) {
    const auto geometry = estimator.verify(kLater, image, id);
    ASSERT_TRUE(geometry.has_value()) << "a template that was dropped must not reject a recall";
    if (geometry->inliers > 0) kept.insert(id);
  }
  ASSERT_EQ(kept.size(), 6U);
  EXPECT_EQ(*kept.begin(), 0U);
  EXPECT_EQ(*kept.rbegin(), 23U);
  for (auto it = kept.begin(); std::next(it) != kept.end(); ++it) EXPECT_LE(*std::next(it) - *it, 12U);
}

TEST(RecallGeometryEstimator, TimeGoingBackForgetsTheImagesBefore) {
  RecallGeometryEstimator estimator(params(), RecallScene::camera());
  for (int i = 0; i < 6; ++i) estimator.frame((50 + i) * kTenth, street().view(0.5 * i, 0.0, 0.0));
  estimator.learned(kTenth, street().view(3.0, 0.0, 0.0), 0);
  const auto geometry = estimator.verify(kLater, street().view(3.5, 0.0, 0.0), 0);
  ASSERT_TRUE(geometry.has_value());
  EXPECT_EQ(geometry->companion_stamp, kTenth);
  EXPECT_EQ(geometry->template_stamp, kTenth);
}

auto values(const std::optional<RecallGeometry>& g) {
  return std::make_tuple(g->relative_rad, g->direction_rad, g->distance_ratio, g->sigma_rotation,
                         g->sigma_direction, g->sigma_ratio, g->inliers);
}

TEST(RecallGeometryEstimator, TheSameImagesGiveTheSameBitsInAnyThread) {
  const cv::Mat now = street().view(0.4, 0.5, 0.1);
  RecallGeometryEstimator first = learnedAtOrigin(street());
  const auto expected = first.verify(kLater, now, 5);
  ASSERT_TRUE(expected.has_value());
  EXPECT_EQ(values(first.verify(kLater + kTenth, now, 5)), values(expected));

  const int threads = cv::getNumThreads();
  const std::vector<cv::Mat> approach = approachToOrigin(street(), kApproach);
  for (const int count : {1, 4}) {
    cv::setNumThreads(count);
    cv::theRNG().state = static_cast<std::uint64_t>(count) * 77U;
    std::array<std::optional<RecallGeometry>, 2> results;
    std::array<std::thread, 2> workers;
    for (std::size_t w = 0; w < workers.size(); ++w) {
      workers[w] = std::thread([&results, &approach, &now, w] {
        RecallGeometryEstimator estimator = learnedFrom(approach);
        results[w] = estimator.verify(kLater, now, 5);
      });
    }
    for (std::thread& worker : workers) worker.join();
    for (const auto& result : results) {
      ASSERT_TRUE(result.has_value());
      EXPECT_EQ(values(result), values(expected));
    }
  }
  cv::setNumThreads(threads);
}

TEST(RecallGeometryEstimator, AnnouncedFramesAndRepeatedStampsChangeNothing) {
  const cv::Mat now = street().view(0.4, 0.5, 0.1);
  RecallGeometryEstimator plain = learnedAtOrigin(street());
  RecallGeometryEstimator announced = learnedAtOrigin(street());
  announced.frame(kLater, street().view(-3.0, 0.0, 0.0));  // the next image of that stamp takes its place
  announced.frame(kLater, now);
  EXPECT_EQ(values(announced.verify(kLater, now, 5)), values(plain.verify(kLater, now, 5)));
}

TEST(RecallGeometryEstimator, SwitchedOffItKeepsAndMeasuresNothing) {
  RecallGeometryEstimator estimator(RecallGeometryParams{}, CameraModel{});
  estimator.frame(0, street().view(0.0, 0.0, 0.0));
  estimator.learned(0, street().view(0.0, 0.0, 0.0), 0);
  const auto geometry = estimator.verify(kTenth, street().view(0.0, 0.0, 0.0), 0);
  ASSERT_TRUE(geometry.has_value());
  EXPECT_EQ(geometry->inliers, 0);
  EXPECT_EQ(estimator.memoryBytes(), 0U);
}

TEST(RecallGeometryEstimator, BadInputIsRefused) {
  RecallGeometryParams p = params();
  p.verify = "sift";
  EXPECT_THROW(RecallGeometryEstimator(p, RecallScene::camera()), std::invalid_argument);
  p = params();
  p.features = 49;
  EXPECT_THROW(RecallGeometryEstimator(p, RecallScene::camera()), std::invalid_argument);
  p = params();
  p.min_inliers = p.features + 1;
  EXPECT_THROW(RecallGeometryEstimator(p, RecallScene::camera()), std::invalid_argument);
  CameraModel camera = RecallScene::camera();
  camera.fx = std::nan("");
  EXPECT_THROW(RecallGeometryEstimator(params(), camera), std::invalid_argument);

  RecallGeometryEstimator estimator(params(), RecallScene::camera());
  EXPECT_THROW(estimator.frame(0, cv::Mat()), std::invalid_argument);
  EXPECT_THROW(estimator.frame(0, cv::Mat(240, 640, CV_32F, cv::Scalar(0.0))), std::invalid_argument);
  estimator.frame(0, street().view(0.0, 0.0, 0.0));
  EXPECT_THROW(estimator.frame(1, cv::Mat(120, 640, CV_8U, cv::Scalar(0.0))), std::invalid_argument);
}

}  // namespace
}  // namespace ratslam
