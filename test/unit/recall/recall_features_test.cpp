#include "ratslam/vision/recall_features.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <set>
#include <utility>

#include "unit/recall/recall_scene.h"

namespace ratslam {
namespace {

cv::Mat picture() {
  const cv::Mat texture = makeTexture(11).front();
  return texture(cv::Rect(0, 0, 640, 240)).clone();
}

TEST(RecallFeatures, CoverTheImageWithAnyNumber) {
  const RecallFeatures all = extractRecallFeatures(picture(), RecallScene::camera(), 600);
  EXPECT_EQ(all.size(), 600U);
  EXPECT_EQ(all.descriptors.rows, 600);
  for (const std::size_t count : {std::size_t{150}, std::size_t{600}}) {
    const RecallFeatures some = firstFeatures(all, count);
    std::set<std::pair<int, int>> cells;
    for (const Eigen::Vector2f& b : some.bearings) {
      const CameraModel camera = RecallScene::camera();
      cells.insert({static_cast<int>((b.x() * camera.fx + camera.cx) / 80.0),
                    static_cast<int>((b.y() * camera.fy + camera.cy) / 80.0)});
    }
    EXPECT_GE(cells.size(), 22U) << "of 24 cells, with " << count << " features";
  }
}

TEST(RecallFeatures, MatchThemselvesUnderShiftAndRotation) {
  const cv::Mat image = picture();
  const CameraModel camera = RecallScene::camera();
  for (const double degrees : {0.0, 30.0}) {
    cv::Mat motion = cv::getRotationMatrix2D({320.0F, 120.0F}, degrees, 1.0);
    motion.at<double>(0, 2) += 17.0;
    cv::Mat moved;
    cv::warpAffine(image, moved, motion, image.size());
    const RecallFeatures first = extractRecallFeatures(image, camera, 500);
    const RecallFeatures second = extractRecallFeatures(moved, camera, 1500);
    const std::vector<RecallMatch> matches = matchRecallFeatures(first, second);
    int right = 0;
    for (const RecallMatch& match : matches) {
      const Eigen::Vector2f a = first.bearings[static_cast<std::size_t>(match.first)];
      const Eigen::Vector2f b = second.bearings[static_cast<std::size_t>(match.second)];
      const double x = a.x() * camera.fx + camera.cx;
      const double y = a.y() * camera.fy + camera.cy;
      const double dx = motion.at<double>(0, 0) * x + motion.at<double>(0, 1) * y + motion.at<double>(0, 2) -
                        (b.x() * camera.fx + camera.cx);
      const double dy = motion.at<double>(1, 0) * x + motion.at<double>(1, 1) * y + motion.at<double>(1, 2) -
                        (b.y() * camera.fy + camera.cy);
      if (std::hypot(dx, dy) < 4.0) ++right;
    }
    EXPECT_GE(matches.size(), 100U) << degrees << " degrees";
    EXPECT_GE(right, 0.9 * static_cast<double>(matches.size())) << degrees << " degrees";
  }
}

TEST(RecallFeatures, BearingsAreFreeOfTheLens) {
  CameraModel bent = RecallScene::camera();
  bent.model = LensModel::kPlumbBob;
  bent.coefficients = {-0.2, 0.03};
  const RecallFeatures plain = extractRecallFeatures(picture(), RecallScene::camera(), 200);
  const RecallFeatures through_lens = extractRecallFeatures(picture(), bent, 200);
  ASSERT_EQ(plain.size(), through_lens.size());
  double farthest = 0.0;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    const Eigen::Vector2d pixel(bent.fx * through_lens.bearings[i].x() + bent.cx,
                                bent.fy * through_lens.bearings[i].y() + bent.cy);
    const Eigen::Vector2d raw(bent.fx * plain.bearings[i].x() + bent.cx,
                              bent.fy * plain.bearings[i].y() + bent.cy);
    EXPECT_NEAR((bent.distort(pixel) - raw).norm(), 0.0, 1e-3);
    farthest = std::max(farthest, (pixel - raw).norm());
  }
  EXPECT_GT(farthest, 10.0);
}

TEST(RecallFeatures, LargeImagesKeepTheirBearings) {
  cv::Mat large;
  cv::resize(picture(), large, {}, 4.0, 4.0, cv::INTER_CUBIC);
  CameraModel camera = RecallScene::camera();
  camera.fx *= 4.0;
  camera.fy *= 4.0;
  camera.cx = 4.0 * (camera.cx + 0.5) - 0.5;
  camera.cy = 4.0 * (camera.cy + 0.5) - 0.5;
  const RecallFeatures small = extractRecallFeatures(picture(), RecallScene::camera(), 500);
  const RecallFeatures of_large = extractRecallFeatures(large, camera, 1500);
  const std::vector<RecallMatch> matches = matchRecallFeatures(small, of_large);
  ASSERT_GE(matches.size(), 50U);
  Eigen::Vector2d mean(0.0, 0.0);
  int right = 0;
  for (const RecallMatch& match : matches) {
    const Eigen::Vector2f difference = small.bearings[static_cast<std::size_t>(match.first)] -
                                       of_large.bearings[static_cast<std::size_t>(match.second)];
    if (difference.norm() > 4.0 / 360.0) continue;
    mean += difference.cast<double>();
    ++right;
  }
  EXPECT_GE(right, 0.9 * static_cast<double>(matches.size()));
  EXPECT_NEAR(mean.norm() / right, 0.0, 0.15 / 360.0);
}

TEST(RecallFeatures, NothingToSeeIsNoError) {
  const CameraModel camera = RecallScene::camera();
  const RecallFeatures blank = extractRecallFeatures(cv::Mat(240, 640, CV_8U, cv::Scalar(50)), camera, 300);
  EXPECT_EQ(blank.size(), 0U);
  EXPECT_EQ(extractRecallFeatures(cv::Mat(20, 20, CV_8U, cv::Scalar(50)), camera, 300).size(), 0U);
  EXPECT_TRUE(matchRecallFeatures(blank, blank).empty());
  EXPECT_TRUE(matchRecallFeatures(extractRecallFeatures(picture(), camera, 300), blank).empty());
}

}  // namespace
}  // namespace ratslam
