#include <gtest/gtest.h>

#include "ratslam/common/state.h"
#include "ratslam/local_view/recall/recall_geometry_estimator.h"
#include "unit/recall/recall_scene.h"

namespace ratslam {
namespace {

TEST(RecallGeometryState, ContinuesWithTheSameBits) {
  RecallGeometryParams params;
  params.verify = "orb";
  RecallGeometryEstimator whole(params, RecallScene::camera());
  RecallGeometryEstimator continued(params, RecallScene::camera());
  const RecallScene scene(7);
  for (int i = 0; i < 12; ++i) {
    const cv::Mat image = scene.view(0.5 * i, 0.0, 0.0);
    if (i == 7) {
      State state;
      whole.save(state);
      continued.load(State::fromBytes(state.toBytes()));
    }
    for (RecallGeometryEstimator* estimator : {&whole, &continued}) {
      if (estimator == &continued && i < 7) continue;
      if (i == 4 || i == 9) estimator->learned(i, image, static_cast<std::uint32_t>(i));
      estimator->frame(i, image);
    }
  }
  for (const std::uint32_t id : {4U, 9U}) {
    const cv::Mat image = scene.view(0.5 * id + 0.3, 0.2, 0.05);
    const auto expected = whole.verify(100 + id, image, id);
    const auto geometry = continued.verify(100 + id, image, id);
    ASSERT_TRUE(expected && geometry);
    State of_expected;
    State of_geometry;
    of_expected.write(*expected);
    of_geometry.write(*geometry);
    EXPECT_TRUE(of_expected == of_geometry) << "template " << id;
    EXPECT_GT(expected->inliers, 0);
  }
}

/// The features of an image of another camera would get wrong bearings.
TEST(RecallGeometryState, ImagesOfAnotherCameraAreLeftOut) {
  RecallGeometryParams params;
  params.verify = "orb";
  RecallGeometryEstimator first(params, RecallScene::camera());
  const RecallScene scene(7);
  for (int i = 0; i < 3; ++i) first.frame(i, scene.view(0.5 * i, 0.0, 0.0));
  State state;
  first.save(state);
  const auto frames = [](const State& saved) {
    return saved.forEach("frames", [](const State&, std::size_t) {});
  };
  CameraModel another = RecallScene::camera();
  for (const std::size_t kept : {3U, 0U}) {
    RecallGeometryEstimator second(params, another);
    second.load(state);
    State saved;
    second.save(saved);
    EXPECT_EQ(frames(saved), kept);
    another.height /= 2;
  }
}

}  // namespace
}  // namespace ratslam
