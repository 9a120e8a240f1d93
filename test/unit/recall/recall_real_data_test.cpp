#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "ratslam/common/angles.h"
#include "ratslam/local_view/recall/recall_geometry_estimator.h"

namespace ratslam {
namespace {

constexpr Stamp kTenth = 100000000;

/// The real frames of a drive that comes back: frames 1569-1637 retrace frames 122-202.
class RealRecalls : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* named = std::getenv("RATSLAM_DATA");
    folder_ = (named != nullptr ? std::string(named) : RATSLAM_SOURCE_DIR "/../shared/data") + "/kitti_00/";
    std::ifstream file(folder_ + "poses.txt");
    if (!file) GTEST_SKIP() << "no " << folder_ << ": set RATSLAM_DATA";
    for (Eigen::Isometry3d pose = Eigen::Isometry3d::Identity(); file;) {
      for (int k = 0; k < 12; ++k) file >> pose.matrix()(k / 4, k % 4);
      if (file) poses_.push_back(pose);
    }
  }
  cv::Mat image(int frame) const {
    char name[32];
    std::snprintf(name, sizeof(name), "image_0/%06d.jpg", frame);
    return cv::imread(folder_ + name, cv::IMREAD_GRAYSCALE);
  }
  /// An estimator that has learned the image of `frame`.
  RecallGeometryEstimator learned(int frame) const {
    RecallGeometryParams params;
    params.verify = "orb";
    const CameraModel camera{1241, 376, 718.856, 718.856, 607.1928, 185.2157, LensModel::kNone, {}};
    RecallGeometryEstimator estimator(params, camera);
    for (int k = frame - 3; k <= frame; ++k) estimator.frame(k * kTenth, image(k));
    estimator.learned(frame * kTenth, image(frame), 0);
    return estimator;
  }

  std::string folder_;
  std::vector<Eigen::Isometry3d> poses_;
};

TEST_F(RealRecalls, NearFramesAgreeWithTheTruth) {
  for (const int frame : {146, 400, 1000}) {
    RecallGeometryEstimator estimator = learned(frame);
    const auto geometry = estimator.verify((frame + 2) * kTenth, image(frame + 2), 0);
    ASSERT_TRUE(geometry.has_value());
    const auto at = [this](int k) { return poses_[static_cast<std::size_t>(k)]; };
    const Eigen::Isometry3d truth = at(frame).inverse() * at(frame + 2);
    const double baseline = (at(frame).translation() - at(frame - 3).translation()).norm();
    const double length = std::hypot(truth.translation().x(), truth.translation().z());
    EXPECT_NEAR(geometry->relative_rad, std::atan2(-truth.linear()(0, 2), truth.linear()(2, 2)),
                degreesToRadians(0.2));
    EXPECT_NEAR(geometry->direction_rad, std::atan2(-truth.translation().x(), truth.translation().z()),
                degreesToRadians(2.0));
    EXPECT_NEAR(geometry->distance_ratio * baseline, length, 0.03 * length);
  }
}

TEST_F(RealRecalls, ConfirmsTheLoopAndRejectsOtherPlaces) {
  RecallGeometryEstimator straight = learned(155);
  const auto same = straight.verify(1599 * kTenth, image(1599), 0);
  ASSERT_TRUE(same.has_value());
  EXPECT_GE(same->inliers, 200);
  RecallGeometryEstimator turning = learned(123);
  const auto turned = turning.verify(1570 * kTenth, image(1570), 0);
  ASSERT_TRUE(turned.has_value());
  // The truth of the two passes disagrees with itself by a degree or two.
  EXPECT_NEAR(turned->relative_rad, degreesToRadians(-20.2), degreesToRadians(2.5));
  for (const int elsewhere : {500, 800, 1100, 1400}) {
    EXPECT_FALSE(straight.verify((2000 + elsewhere) * kTenth, image(elsewhere), 0).has_value());
  }
}

}  // namespace
}  // namespace ratslam
