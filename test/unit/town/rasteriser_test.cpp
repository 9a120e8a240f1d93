#include "town/rasteriser.h"

#include <gtest/gtest.h>
#include <pthread.h>

#include <opencv2/imgproc.hpp>

#include "ratslam/common/params.h"
#include "town_test_support.h"

namespace ratslam {
namespace {

/// Draws triangles alone, without a town.
class Scene {
 public:
  Scene(const TownCamera& camera, const TextureLibrary& textures)
      : camera_(camera), textures_(textures), shader_(textures_, camera) {}
  Mesh mesh;
  const TextureLibrary& textures() const { return textures_; }
  RasterImage draw(const Eigen::Isometry3d& T_world_camera, int threads = 1) const {
    std::vector<ScreenTriangle> triangles;
    for (const MeshTriangle& triangle : mesh.triangles())
      if (const auto screen = projectTriangle(triangle, T_world_camera.inverse(), camera_))
        triangles.push_back(*screen);
    return Rasteriser(shader_, camera_, threads).draw(triangles, T_world_camera.linear().cast<float>(), true);
  }

 private:
  TownCamera camera_;
  const TextureLibrary& textures_;
  Shader shader_;
};

class Rasterising : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { textures_ = std::make_unique<TextureLibrary>(5); }
  static void TearDownTestSuite() { textures_.reset(); }
  static std::unique_ptr<TextureLibrary> textures_;
};
std::unique_ptr<TextureLibrary> Rasterising::textures_;

const TownCamera kCamera = TownCamera::kittiLike(320, 240);

Eigen::Vector2d projectPoint(const Eigen::Isometry3d& T_world_camera, const Eigen::Vector3d& point) {
  const Eigen::Vector3d p = T_world_camera.inverse() * point;
  return {kCamera.fx * p.x() / p.z() + kCamera.cx, kCamera.fy * p.y() / p.z() + kCamera.cy};
}

TEST_F(Rasterising, DrawsTheSamePictureWhereNoThreadCanBeStarted) {
  Scene scene(kCamera, *textures_);
  Finish finish;
  finish.texture = scene.textures().planks();
  scene.mesh.addBox(UprightFrame(0.0, 6.0, -1.0, 0.0, 1.0), {-1.0, 1.0, 0.0, 2.0, 0.0, 1.0}, finish, 1.0);
  const cv::Mat alone = scene.draw(poseAt(0.0, 0.0, 0.0, 0.0)).grey;
  pthread_attr_t usual;
  pthread_attr_t huge;
  ASSERT_EQ(pthread_getattr_default_np(&usual), 0);
  ASSERT_EQ(pthread_getattr_default_np(&huge), 0);
  ASSERT_EQ(pthread_attr_setstacksize(&huge, std::size_t{1} << 50), 0);  // more than the system can give
  ASSERT_EQ(pthread_setattr_default_np(&huge), 0);
  cv::Mat refused;
  EXPECT_NO_THROW(refused = scene.draw(poseAt(0.0, 0.0, 0.0, 0.0), 4).grey);
  ASSERT_EQ(pthread_setattr_default_np(&usual), 0);
  EXPECT_TRUE(equalBytes(alone, refused));
}

TEST_F(Rasterising, CoversTheAreaThatGeometrySays) {
  // A board in front of a turned camera: the share of covered pixels is the area of its projected outline.
  Scene scene(kCamera, *textures_);
  Finish finish;
  finish.texture = scene.textures().plain();
  const std::array<Eigen::Vector3f, 4> board{Eigen::Vector3f(-1, 1, 6), Eigen::Vector3f(1.2F, 0.8F, 7),
                                             Eigen::Vector3f(1.2F, -1.2F, 7), Eigen::Vector3f(-1, -1, 6)};
  scene.mesh.addQuad(board[0], board[1], board[2], board[3], {}, finish);
  const Eigen::Isometry3d pose = poseAt(0.3, -0.1, 0.2, 0.1);
  std::vector<cv::Point2f> outline;
  for (const Eigen::Vector3f& corner : board) {
    const Eigen::Vector2d pixel = projectPoint(pose, corner.cast<double>());
    outline.emplace_back(static_cast<float>(pixel.x()), static_cast<float>(pixel.y()));
  }
  const RasterImage image = scene.draw(pose);
  const double length = cv::arcLength(outline, true);
  // A pixel counts when any of its samples is covered: half a pixel more, all round.
  EXPECT_NEAR(cv::countNonZero(image.inverse_depth), cv::contourArea(outline) + 0.4 * length, 0.3 * length);
}

TEST_F(Rasterising, PutsACornerWhereItProjects) {
  // Four boards meet in one point, black and white like a chess board: its sub-pixel place is known.
  Scene scene(kCamera, *textures_);
  Finish dark;
  dark.texture = scene.textures().plain();
  dark.brightness = 0.2F;
  dark.stain_scale = 0.0F;
  Finish bright = dark;
  bright.brightness = 1.4F;
  const Eigen::Vector3d meeting(0.4, 0.3, 8.0);
  const auto at = [&](double right, double up) -> Eigen::Vector3f {
    return (meeting + Eigen::Vector3d(right, -up, 0.0)).cast<float>();
  };
  for (const bool right : {false, true})
    for (const bool up : {false, true}) {
      const double r = right ? 0.0 : -1.5;
      const double u = up ? 0.0 : -1.5;
      scene.mesh.addQuad(at(r, u), at(r + 1.5, u), at(r + 1.5, u + 1.5), at(r, u + 1.5), {},
                         right == up ? dark : bright);
    }
  for (const double bearing : {-0.08, 0.0, 0.03}) {
    Eigen::Isometry3d pose = poseAt(0.13, 0.0, 0.4, bearing);
    pose.rotate(Eigen::AngleAxisd(0.15, Eigen::Vector3d::UnitZ()));
    const Eigen::Vector2d expected = projectPoint(pose, meeting);
    std::vector<cv::Point2f> corner{
        {static_cast<float>(expected.x() + 0.8), static_cast<float>(expected.y() - 0.7)}};
    cv::Mat grey;
    scene.draw(pose).grey.convertTo(grey, CV_8U);
    cv::cornerSubPix(grey, corner, {6, 6}, {-1, -1},
                     {cv::TermCriteria::EPS | cv::TermCriteria::MAX_ITER, 50, 1e-4});
    EXPECT_NEAR(corner[0].x, expected.x(), 0.12);
    EXPECT_NEAR(corner[0].y, expected.y(), 0.12);
  }
}

TEST_F(Rasterising, NeighboursLeaveNoGapAlsoAcrossTheNearPlane) {
  // A floor of many squares reaches from behind the camera to far ahead: below the horizon no sky shows
  // through.
  Scene scene(kCamera, *textures_);
  Finish finish;
  finish.texture = scene.textures().grass();
  for (int x = -30; x < 30; ++x)
    for (int z = -6; z < 60; ++z) {
      const auto at = [](int right, int ahead) {
        return Eigen::Vector3f(static_cast<float>(right), 1.65F, static_cast<float>(ahead));
      };
      scene.mesh.addQuad(at(x, z), at(x + 1, z), at(x + 1, z + 1), at(x, z + 1), {}, finish);
    }
  const RasterImage image = scene.draw(poseAt(0.21, 0.0, 0.33, 0.17));
  const int horizon = static_cast<int>(kCamera.cy);
  const cv::Mat floor = image.inverse_depth.rowRange(horizon + 15, kCamera.height);
  EXPECT_EQ(cv::countNonZero(floor == 0.0F), 0);
}

TEST_F(Rasterising, NearThingsHideFarOnesInAnyOrder) {
  Finish finish;
  const auto board = [&](Scene& scene, float depth) {
    finish.texture = scene.textures().plain();
    scene.mesh.addQuad({-1, 1, depth}, {1, 1, depth}, {1, -1, depth}, {-1, -1, depth}, {}, finish);
  };
  Scene near_first(kCamera, *textures_);
  board(near_first, 4.0F);
  board(near_first, 9.0F);
  Scene far_first(kCamera, *textures_);
  board(far_first, 9.0F);
  board(far_first, 4.0F);
  const RasterImage a = near_first.draw(Eigen::Isometry3d::Identity());
  const RasterImage b = far_first.draw(Eigen::Isometry3d::Identity());
  EXPECT_TRUE(equalBytes(a.grey, b.grey));
  EXPECT_NEAR(a.inverse_depth.at<float>(120, 160), 0.25F, 1e-6F);
}

TEST(Texture, MipMapsKeepTheMeanAndSmoothTheRest) {
  std::vector<float> chess(64 * 64);
  for (std::size_t i = 0; i < chess.size(); ++i) chess[i] = ((i + i / 64) % 2 == 0) ? 40.0F : 200.0F;
  const Texture texture(64, chess);
  EXPECT_NEAR(texture.sample(0.5F / 64, 0.5F / 64, 0.0F), 40.0F, 1.0F);
  EXPECT_NEAR(texture.sample(1.5F / 64, 0.5F / 64, 0.0F), 200.0F, 1.0F);
  for (const float lod : {1.0F, 2.5F, 6.0F, 9.0F}) EXPECT_NEAR(texture.sample(0.3F, 0.7F, lod), 120.0F, 1.0F);
  // It repeats, also to the left of 0, and half-way between two texels is their mean.
  EXPECT_NEAR(texture.sample(-63.5F / 64, 2.0F + 0.5F / 64, 0.0F), 40.0F, 1.0F);
  EXPECT_NEAR(texture.sample(1.0F / 64, 0.5F / 64, 0.0F), 120.0F, 1.5F);
  EXPECT_THROW(Texture(48, std::vector<float>(48 * 48)), std::invalid_argument);
  EXPECT_THROW(Texture(32, std::vector<float>(7)), std::invalid_argument);
}

}  // namespace
}  // namespace ratslam
