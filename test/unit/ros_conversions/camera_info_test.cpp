#include "ratslam_ros/support/camera_info.h"

#include <gtest/gtest.h>

#include "unit/message_of.h"

namespace ratslam {
namespace {

void expectWords(const sensor_msgs::CameraInfo& info, const cv::Size& images, const std::string& words) {
  const std::string said =
      test::messageOf<std::invalid_argument>([&] { cameraFromMessage(info, false, images); });
  EXPECT_NE(said.find(words), std::string::npos) << said;
}

// K and P are those of the whole sensor (sensor_msgs/CameraInfo).
TEST(CameraInfoTest, ARegionOfInterestAndBinningMoveAndShrinkThePicture) {
  sensor_msgs::CameraInfo info;
  info.width = 1280;
  info.height = 960;
  info.K = {800.0, 0.0, 639.5, 0.0, 800.0, 479.5, 0.0, 0.0, 1.0};
  info.binning_x = info.binning_y = 2;
  const CameraModel binned = cameraFromMessage(info, false, {640, 480});
  EXPECT_EQ(binned.fx, 400.0);
  EXPECT_EQ(binned.cx, 319.5) << "the middle stays the middle";
  EXPECT_EQ(binned.cy, 239.5);
  info.roi.x_offset = 320;
  info.roi.y_offset = 200;
  info.roi.width = 640;
  info.roi.height = 400;
  const CameraModel part = cameraFromMessage(info, false, {320, 200});
  EXPECT_EQ(part.cx, 159.5);
  EXPECT_EQ(part.cy, 139.5);
  expectWords(info, {640, 480},
              "images of 320x200 (after its region of interest and binning), they are of 640x480");
  info.roi.x_offset = 641;
  expectWords(info, {}, "640x400 from (641, 200), does not lie within its 1280x960");
  info.roi.x_offset = 0xffffffff;
  EXPECT_THROW(cameraFromMessage(info), std::invalid_argument);
  info.roi = {};
  info.binning_x = 5000;
  expectWords(info, {}, "binning of 5000x2 leaves no pixel");
}

}  // namespace
}  // namespace ratslam
