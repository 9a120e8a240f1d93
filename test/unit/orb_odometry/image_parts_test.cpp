/// Parts that look at images: features, patches, the road.
#include <gtest/gtest.h>

#include <array>
#include <opencv2/imgproc.hpp>

#include "ratslam/common/angles.h"
#include "ratslam/odometry/orb/ground_plane.h"
#include "ratslam/vision/matching.h"
#include "ratslam/vision/patch_alignment.h"
#include "street_scene.h"

namespace ratslam {
namespace {

using test::cameraAt;
using test::smallCamera;
using test::StreetScene;

Frame frameOf(const cv::Mat& image, const RigidTransform& T_world_camera = {}) {
  ExtractorParams params;
  params.features = 700;
  CameraModel camera = smallCamera();
  camera.width = image.cols;
  camera.height = image.rows;
  WorkerPool workers(1);
  Frame frame = makeFrame(0, image, camera, FeatureExtractor(params), params, workers);
  frame.T_camera_world = T_world_camera.inverse();
  return frame;
}

TEST(ImagePyramid, KeepsTheCentreOfASpotAtEachLevel) {
  cv::Mat image(200, 301, CV_8UC1, cv::Scalar(10));
  cv::circle(image, {140 * 16 + 5, 90 * 16 + 9}, 12 * 16, cv::Scalar(250), -1, cv::LINE_AA, 4);
  const ImagePyramid pyramid(image, 6, 1.2);
  for (int level = 0; level < pyramid.levels(); ++level) {
    cv::Mat bright;
    cv::subtract(pyramid.image(level), cv::Scalar(10), bright);
    const cv::Moments m = cv::moments(bright);
    const Eigen::Vector2d centre = pyramid.fromLevel({m.m10 / m.m00, m.m01 / m.m00}, level);
    EXPECT_NEAR(centre.x(), 140 + 5.0 / 16, 0.05 * pyramid.scale(level)) << level;
    EXPECT_NEAR(centre.y(), 90 + 9.0 / 16, 0.05 * pyramid.scale(level)) << level;
  }
}

TEST(PointGrid, WithoutSomeFeaturesVisitsTheOthersInTheSameOrder) {
  std::vector<Feature> features(500);
  std::vector<bool> left_out(features.size());
  for (std::size_t i = 0; i < features.size(); ++i) {
    features[i].pixel = {static_cast<double>(i * 37 % 211), static_cast<double>(i * 53 % 97)};
    left_out[i] = i % 3 == 0;
  }
  const PointGrid grid(features, 24.0);
  std::vector<int> expected;
  grid.forEachNear({90, 40}, 60.0, [&](const PointGrid::Point& point) {
    if (!left_out[static_cast<std::size_t>(point.feature)]) expected.push_back(point.feature);
  });
  std::vector<int> visited;
  grid.without(left_out).forEachNear(
      {90, 40}, 60.0, [&](const PointGrid::Point& point) { visited.push_back(point.feature); });
  EXPECT_GT(visited.size(), 100U);
  EXPECT_EQ(visited, expected);
}

TEST(FeatureExtractor, SpreadsFeaturesOverAllTexturedPartsOfTheImage) {
  // Strong texture on the left, a tenth of its contrast on the right: both halves must get their share.
  cv::Mat image = StreetScene().render(smallCamera(), cameraAt(0, 0));
  cv::Mat right = image.colRange(240, 480);
  right.convertTo(right, CV_8U, 0.25, 96);
  const Frame frame = frameOf(image);
  EXPECT_GT(frame.features.size(), 500U);
  EXPECT_LE(frame.features.size(), 710U);
  std::array<int, 2> halves{};
  for (const Feature& feature : frame.features) ++halves[feature.raw.x() < 240 ? 0 : 1];
  EXPECT_GT(halves[1], 150);
  EXPECT_EQ(static_cast<std::size_t>(frame.descriptors.rows), frame.features.size());
}

TEST(FeatureExtractor, DescriptorsSurviveARotationOfTheImage) {
  cv::Mat image(240, 240, CV_8UC1);
  cv::RNG generator(3);
  generator.fill(image, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(image, image, {0, 0}, 2.5);
  cv::normalize(image, image, 0, 255, cv::NORM_MINMAX);
  cv::Mat turned;
  const cv::Mat map = cv::getRotationMatrix2D({119.5F, 119.5F}, 40.0, 1.0);
  cv::warpAffine(image, turned, map, image.size(), cv::INTER_LINEAR, cv::BORDER_REFLECT);
  const Frame a = frameOf(image);
  const Frame b = frameOf(turned);
  int near_truth = 0;
  int matched = 0;
  for (int i = 0; i < static_cast<int>(a.features.size()); ++i) {
    int best = 257;
    int feature = -1;
    for (int j = 0; j < static_cast<int>(b.features.size()); ++j) {
      const int distance = hammingDistance(a.descriptor(i), b.descriptor(j));
      if (distance < best) {
        best = distance;
        feature = j;
      }
    }
    if (best > 40) continue;
    ++matched;
    const Eigen::Vector2d& p = a.features[static_cast<std::size_t>(i)].raw;
    const Eigen::Vector2d expected(
        map.at<double>(0, 0) * p.x() + map.at<double>(0, 1) * p.y() + map.at<double>(0, 2),
        map.at<double>(1, 0) * p.x() + map.at<double>(1, 1) * p.y() + map.at<double>(1, 2));
    if ((b.features[static_cast<std::size_t>(feature)].raw - expected).norm() < 4.0) ++near_truth;
  }
  EXPECT_GT(matched, 60);
  EXPECT_GT(near_truth, 0.9 * matched);
}

/// Index of the most similar of the others by a plain search; -1 if the second best is about as similar.
int plainlyMostSimilar(const cv::Mat& from, int i, const cv::Mat& to, int most_distance, double most_ratio) {
  int least = most_distance + 1;
  int second = 256;
  int found = -1;
  for (int k = 0; k < to.rows; ++k) {
    const int distance = static_cast<int>(cv::norm(from.row(i), to.row(k), cv::NORM_HAMMING));
    if (distance < least) {
      second = least;
      least = distance;
      found = k;
    } else {
      second = std::min(second, distance);
    }
  }
  return found >= 0 && least <= most_ratio * second ? found : -1;
}

TEST(Descriptors, MutuallyMostSimilarPairsAreThoseOfTwoPlainSearches) {
  cv::RNG random(7);
  cv::Mat first(150, 32, CV_8U);
  random.fill(first, cv::RNG::UNIFORM, 0, 256);
  cv::Mat second(190, 32, CV_8U);
  random.fill(second, cv::RNG::UNIFORM, 0, 256);
  for (int i = 0; i < 100; ++i) {  // noisy copies, some of them twice
    first.row(random.uniform(0, first.rows)).copyTo(second.row(i));
    for (int flips = random.uniform(0, 90); flips > 0; --flips) {
      std::uint8_t& byte = second.at<std::uint8_t>(i, random.uniform(0, 32));
      byte = static_cast<std::uint8_t>(byte ^ (1 << random.uniform(0, 8)));
    }
  }
  std::vector<std::pair<std::size_t, std::size_t>> expected;
  for (int i = 0; i < first.rows; ++i) {
    const int there = plainlyMostSimilar(first, i, second, 64, 0.85);
    if (there >= 0 && plainlyMostSimilar(second, there, first, 64, 0.85) == i)
      expected.emplace_back(i, there);
  }
  EXPECT_GT(expected.size(), 20U);
  EXPECT_LT(expected.size(), 100U);
  EXPECT_EQ(mutuallyMostSimilar(first, second, 64, 0.85), expected);
  EXPECT_TRUE(mutuallyMostSimilar(first, cv::Mat(), 64, 0.85).empty());
  EXPECT_TRUE(mutuallyMostSimilar(cv::Mat(), second, 64, 0.85).empty());
}

TEST(PatchAlignment, MeasuresAShiftToAFewHundredthsOfAPixelDespiteAnExposureChange) {
  const cv::Mat image = StreetScene().render(smallCamera(), cameraAt(0, 0));
  cv::Mat shifted;
  const Eigen::Vector2d shift(0.37, -0.61);
  const cv::Matx23d map(1, 0, shift.x(), 0, 1, shift.y());
  cv::warpAffine(image, shifted, map, image.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
  shifted.convertTo(shifted, CV_8U, 0.7, 25.0);
  const ImagePyramid source(image, 4, 1.2);
  const ImagePyramid target(shifted, 4, 1.2);
  int aligned = 0;
  double squares = 0.0;
  Eigen::Vector2d bias = Eigen::Vector2d::Zero();
  for (const Feature& feature : frameOf(image).features) {
    if (feature.level > 0) continue;
    const auto match = alignPatch({&source, feature.raw, 0}, target, feature.raw, Eigen::Matrix2d::Identity(),
                                  AlignmentLimits{});
    if (!match) continue;
    ++aligned;
    squares += (match->raw - feature.raw - shift).squaredNorm();
    bias += match->raw - feature.raw - shift;
  }
  EXPECT_GT(aligned, 80);
  EXPECT_LT(std::sqrt(squares / aligned), 0.08);
  EXPECT_LT(bias.norm() / aligned, 0.03);
}

TEST(PatchAlignment, RefusesFlatPatchesEdgesOfTheImageAndOtherScenes) {
  const ImagePyramid flat(cv::Mat(100, 100, CV_8UC1, cv::Scalar(120)), 3, 1.2);
  const Eigen::Matrix2d same = Eigen::Matrix2d::Identity();
  EXPECT_FALSE(alignPatch({&flat, {50, 50}, 0}, flat, {50, 50}, same, AlignmentLimits{}));
  const ImagePyramid street(StreetScene().render(smallCamera(), cameraAt(0, 0)), 3, 1.2);
  const ImagePyramid elsewhere(StreetScene().render(smallCamera(), cameraAt(0, 40)), 3, 1.2);
  EXPECT_FALSE(alignPatch({&street, {1, 1}, 0}, street, {1, 1}, same, AlignmentLimits{}));
  EXPECT_FALSE(alignPatch({&street, {100, 120}, 0}, elsewhere, {100, 120}, same, AlignmentLimits{}));
}

class Road : public testing::Test {
 protected:
  static constexpr double kUnit = 0.4;  // metres a unit of the odometry
  Frame at(double z, double yaw = 0.0) const {
    RigidTransform pose = cameraAt(0.2, z, yaw);
    Frame frame = frameOf(scene_.render(smallCamera(), pose), pose);
    pose.translation /= kUnit;
    frame.T_camera_world = pose.inverse();
    return frame;
  }
  StreetScene scene_;
};

TEST_F(Road, HeightComesOutInTheOdometrysUnit) {
  const Frame before = at(0.0);
  const Frame now = at(0.9, 0.02);
  const double truth = StreetScene::kCameraHeight / kUnit;
  const auto tracked =
      measureRoad(smallCamera(), now, {&before}, {Eigen::Vector3d::UnitY(), 1.1 * truth}, RoadParams{});
  ASSERT_TRUE(tracked);
  EXPECT_NEAR(tracked->plane.height, truth, 0.015 * truth);
  const auto searched = searchRoad(smallCamera(), now, {&before}, Eigen::Vector3d::UnitY(), 0.2 * truth,
                                   5.0 * truth, RoadParams{});
  ASSERT_TRUE(searched);
  EXPECT_NEAR(searched->plane.height, truth, 0.015 * truth);
}

TEST_F(Road, FindsThePitchOfTheCamera) {
  RigidTransform tilt{expRotation({-degreesToRadians(1.5), 0, 0}), Eigen::Vector3d::Zero()};  // looks down
  const RigidTransform a = cameraAt(0, 0) * tilt;
  const RigidTransform b = cameraAt(0, 0.9) * tilt;
  const Frame before = frameOf(scene_.render(smallCamera(), a), a);
  const Frame now = frameOf(scene_.render(smallCamera(), b), b);
  // The prior of the tilt gives way step by step, as it does while driving.
  RoadPlane plane{Eigen::Vector3d::UnitY(), StreetScene::kCameraHeight};
  std::optional<RoadMeasurement> road;
  for (int round = 0; round < 6; ++round) {
    road = measureRoad(smallCamera(), now, {&before}, plane, RoadParams{});
    ASSERT_TRUE(road);
    plane = road->plane;
  }
  EXPECT_NEAR(radiansToDegrees(std::asin(road->plane.normal.z())), 1.5, 0.2);
  EXPECT_NEAR(road->plane.height, StreetScene::kCameraHeight, 0.02 * StreetScene::kCameraHeight);
}

TEST_F(Road, IsNotFoundWhereNothingMoves) {
  const Frame now = at(0.0);
  EXPECT_FALSE(searchRoad(smallCamera(), now, {&now}, Eigen::Vector3d::UnitY(), 1.0, 10.0, RoadParams{}));
}

}  // namespace
}  // namespace ratslam
