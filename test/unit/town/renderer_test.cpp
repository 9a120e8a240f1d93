#include <gtest/gtest.h>

#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <set>

#include "town/town_renderer.h"
#include "town_test_support.h"

namespace ratslam {
namespace {

class Renderer : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { fixture_ = std::make_unique<TownFixture>(); }
  static void TearDownTestSuite() { fixture_.reset(); }
  static const Town& town() { return fixture_->town; }
  static const Eigen::Isometry3d& pose(std::size_t frame) {
    return fixture_->drive.poses[frame].T_world_camera;
  }
  static std::unique_ptr<TownFixture> fixture_;
};
std::unique_ptr<TownFixture> Renderer::fixture_;

const TownCamera kSmall = TownCamera::kittiLike(310, 94);

TEST_F(Renderer, SameSeedGivesTheSameBytesWithAnyNumberOfThreads) {
  const Town again(planTownDrive(5).roads, 1);
  const Town other(planTownDrive(5).roads, 2);
  const cv::Mat image = TownRenderer(town(), kSmall).render(pose(40));
  EXPECT_TRUE(equalBytes(image, TownRenderer(again, kSmall).render(pose(40))));
  EXPECT_TRUE(equalBytes(image, TownRenderer(town(), kSmall, 3).render(pose(40))));
  EXPECT_GT(difference(image, TownRenderer(other, kSmall).render(pose(40))), 10.0);
}

TEST_F(Renderer, KeepsTheRoadFreeAlongTheWholeDrive) {
  const TownRenderer renderer(town(), kSmall);
  for (std::size_t frame = 0; frame < TownFixture::kFrames; frame += 13) {
    double low = 0.0;
    double high = 0.0;
    cv::minMaxLoc(renderer.renderInverseDepth(pose(frame)), &low, &high);
    EXPECT_LT(high, 1.0 / 1.5) << "something stands before the camera in frame " << frame;
  }
}

TEST_F(Renderer, DepthOfTheRoadIsThatOfALevelPlane) {
  // The road 1.65 m below a level camera: at row v its depth is 1.65 fy / (v - cy).
  const cv::Mat inverse_depth = TownRenderer(town(), kSmall).renderInverseDepth(pose(20));
  for (const int row : {93, 85, 75}) {
    const double expected = (row - kSmall.cy) / (kCameraHeight * kSmall.fy);
    // The nearest of a pixel's four samples is at most 3/8 of a row lower.
    EXPECT_NEAR(inverse_depth.at<float>(row, 155), expected, 0.5 / (kCameraHeight * kSmall.fy));
  }
}

TEST_F(Renderer, RevisitsLookAlikeAndPlacesDiffer) {
  const TownRenderer renderer(town(), kSmall);
  const auto template_of = [&](const Eigen::Isometry3d& from) {
    cv::Mat small;
    cv::resize(renderer.render(from), small, {60, 10}, 0, 0, cv::INTER_AREA);
    return small;
  };
  std::vector<cv::Mat> places;
  for (const std::size_t frame : {20U, 60U, 100U, 150U, 260U, 300U})
    places.push_back(template_of(pose(frame)));
  double least = 255.0;
  for (std::size_t i = 0; i < places.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) least = std::min(least, difference(places[i], places[k]));
  Eigen::Isometry3d near = pose(20);
  near.translate(Eigen::Vector3d(0.1, 0.0, 0.2));
  EXPECT_GT(difference(places[0], template_of(near)), 0.0);
  EXPECT_LT(difference(places[0], template_of(near)), 0.5 * least);
}

TEST_F(Renderer, ImagesAreRichInWellSpreadCorners) {
  const TownRenderer renderer(town(), TownCamera{});
  for (const std::size_t frame : {0U, 90U, 200U, 333U}) {
    const cv::Mat image = renderer.render(pose(frame));
    std::vector<cv::KeyPoint> corners;
    cv::FAST(image, corners, 20, true);
    EXPECT_GT(corners.size(), 1800U) << frame;
    std::set<std::pair<int, int>> cells;  // of a 40 x 12 grid, below the sky
    for (const cv::KeyPoint& corner : corners) {
      const int row = static_cast<int>(corner.pt.y * 12.0F / static_cast<float>(image.rows));
      if (row >= 4)
        cells.emplace(static_cast<int>(corner.pt.x * 40.0F / static_cast<float>(image.cols)), row);
    }
    EXPECT_GT(static_cast<double>(cells.size()), 0.7 * 40 * 8) << frame;
  }
}

TEST_F(Renderer, SmallMotionsDoNotShimmer) {
  // Turning by a tenth of a pixel may not change more than a tenth of what turning by a whole pixel changes,
  // but for the filter's rounding: aliased textures change by as much in both cases.
  const TownRenderer renderer(town(), kSmall);
  const auto turned = [&](double pixels) {
    Eigen::Isometry3d to = pose(120);
    to.rotate(Eigen::AngleAxisd(pixels / kSmall.fx, Eigen::Vector3d::UnitY()));
    return renderer.renderFloat(to);
  };
  const auto change = [](const cv::Mat& a, const cv::Mat& b) {
    return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
  };
  const cv::Mat start = turned(0.0);
  EXPECT_LT(change(start, turned(0.1)), 0.3 * change(start, turned(1.0)));
}

TEST_F(Renderer, DistortedPictureShowsThingsWhereTheLensModelPutsThem) {
  TownCamera camera = TownCamera::kittiLike(320, 240);
  const cv::Mat ideal = TownRenderer(town(), camera).render(pose(30));
  camera.distortion = {-0.25, 0.06, 0.001, -0.0005, 0.0};
  const cv::Mat distorted = TownRenderer(town(), camera).render(pose(30));
  const cv::Mat K = (cv::Mat_<double>(3, 3) << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  std::vector<cv::Point3d> rays;
  std::vector<cv::Point2d> pixels;
  for (double v = 20; v < 230; v += 15)
    for (double u = 20; u < 310; u += 15) {
      pixels.emplace_back(u, v);
      rays.emplace_back((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
    }
  std::vector<cv::Point2d> projected;
  const std::vector<double> lens(camera.distortion.begin(), camera.distortion.end());
  cv::projectPoints(rays, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), K, lens, projected);
  double there = 0.0;
  double elsewhere = 0.0;
  const auto patch = [](const cv::Mat& image, const cv::Point2d& centre) {
    cv::Mat result;
    cv::getRectSubPix(image, {5, 5}, {static_cast<float>(centre.x), static_cast<float>(centre.y)}, result);
    return result;
  };
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    there += difference(patch(ideal, pixels[i]), patch(distorted, projected[i]));
    elsewhere += difference(patch(ideal, pixels[i]), patch(distorted, projected[i] + cv::Point2d(3.0, 0.0)));
  }
  EXPECT_LT(there, 0.4 * elsewhere);
}

TEST_F(Renderer, RefusesImpossibleCameras) {
  TownCamera folding = kSmall;
  folding.distortion = {-1.5, 0.0, 0.0, 0.0, 0.0};
  EXPECT_NE(complaint([&] { TownRenderer(town(), folding); }).find("distortion"), std::string::npos);
  TownCamera blind = kSmall;
  blind.fx = 0.0;
  EXPECT_NE(complaint([&] { TownRenderer(town(), blind); }).find("fx: value 0"), std::string::npos);
  EXPECT_NE(complaint([&] { TownRenderer(town(), kSmall, 0); }).find("threads: value 0"), std::string::npos);
}

}  // namespace
}  // namespace ratslam
