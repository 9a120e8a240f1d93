/// The odometry on the first real frames of KITTI odometry sequence 00; skipped where the data are absent.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "ratslam/odometry/orb/orb_odometry.h"

namespace ratslam {
namespace {

constexpr int kFrames = 120;

std::string dataFolder() {
  const char* folder = std::getenv("RATSLAM_DATA");
  return folder ? folder : RATSLAM_SOURCE_DIR "/../shared/data";
}

TEST(Kitti00, IsTrackedAndMetricFromTheCameraHeight) {
  const std::string folder = dataFolder() + "/kitti_00/";
  std::ifstream calibration(folder + "calib.txt");
  std::ifstream truth(folder + "poses.txt");
  std::ifstream times(folder + "times.txt");
  if (!calibration || !truth || !times) GTEST_SKIP() << "no kitti_00 in " << dataFolder();

  std::string name;
  calibration >> name;
  std::array<double, 12> projection{};
  for (double& value : projection) calibration >> value;
  CameraModel camera;
  camera.width = 1241;
  camera.height = 376;
  camera.fx = projection[0];
  camera.fy = projection[5];
  camera.cx = projection[2];
  camera.cy = projection[6];
  OrbOdometryParams params;
  params.camera_height = 1.65;
  OrbOdometry odometry(camera, params);

  std::vector<Eigen::Vector3d> estimated;
  std::vector<Eigen::Vector3d> driven;
  for (int i = 0; i < kFrames; ++i) {
    std::ostringstream path;
    path << folder << "image_0/" << std::setfill('0') << std::setw(6) << i << ".jpg";
    const cv::Mat image = cv::imread(path.str(), cv::IMREAD_GRAYSCALE);
    ASSERT_FALSE(image.empty()) << path.str();
    double time = 0.0;
    times >> time;
    std::array<double, 12> pose{};
    for (double& value : pose) truth >> value;
    const OrbResult result = odometry.track(stampFromSeconds(time), image);
    if (i >= 5) {
      EXPECT_EQ(result.state, OrbState::kTracking) << i;
    }
    estimated.push_back(result.sample.pose->translation());
    driven.emplace_back(pose[11], -pose[3], -pose[7]);  // camera axes to base_link's
  }
  EXPECT_EQ(odometry.restarts(), 0);
  double length = 0.0;
  double length_truth = 0.0;
  for (std::size_t i = 11; i < estimated.size(); ++i) {
    length += (estimated[i] - estimated[i - 1]).norm();
    length_truth += (driven[i] - driven[i - 1]).norm();
  }
  EXPECT_NEAR(length / length_truth, 1.0, 0.04);
  EXPECT_LT((estimated.back() - driven.back()).norm(), 0.05 * length_truth);
}

}  // namespace
}  // namespace ratslam
