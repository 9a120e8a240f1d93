#include "ratslam/camera/camera_params.h"

#include <gtest/gtest.h>

#include "unit/message_of.h"

namespace ratslam {
namespace {

TEST(CameraParams, NoCalibrationIsAllowed) {
  const CameraParams params;
  EXPECT_NO_THROW(params.validate());
  EXPECT_FALSE(params.model());
}

TEST(CameraParams, APartOfACalibrationIsRefusedBecauseItWouldBeIgnored) {
  CameraParams lens;
  lens.distortion = {-0.2, 0.05};
  EXPECT_NE(test::messageOf<std::invalid_argument>([&] { lens.validate(); }).find("camera_distortion"),
            std::string::npos);
  CameraParams size;
  size.width = 640;
  const std::string said = test::messageOf<std::invalid_argument>([&] { size.validate(); });
  EXPECT_NE(said.find("camera_width_px: value 640"), std::string::npos) << said;
  EXPECT_NE(said.find("camera_fx"), std::string::npos) << said;
  CameraParams centre;
  centre.cy = 120.0;
  EXPECT_NE(test::messageOf<std::invalid_argument>([&] { centre.validate(); }).find("camera_cy"),
            std::string::npos);
}

}  // namespace
}  // namespace ratslam
