#include "ratslam/camera/camera_params.h"

#include <gtest/gtest.h>

#include <cmath>

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

TEST(CameraParams, WhatNoCameraHasIsNamedWithItsParameters) {
  CameraParams params;
  params.fx = params.fy = 300.0;
  params.cx = 160.0;
  params.cy = 120.0;
  params.width = 320;
  params.height = 240;
  EXPECT_NO_THROW(params.validate());
  CameraParams flat = params;
  flat.height = 0;
  const std::string said = test::messageOf<std::invalid_argument>([&] { flat.validate(); });
  EXPECT_NE(said.find("camera_height_px"), std::string::npos) << said;
  EXPECT_NE(said.find("value 0"), std::string::npos) << said;
  CameraParams bent = params;
  bent.distortion = {0.1, std::nan("")};
  EXPECT_NE(test::messageOf<std::invalid_argument>([&] { bent.validate(); }).find("camera_distortion"),
            std::string::npos);
  CameraParams fish = params;
  fish.distortion_model = "fish";
  EXPECT_EQ(
      test::messageOf<std::invalid_argument>([&] { fish.validate(); }).find("camera_distortion_model: "), 0U);
}

}  // namespace
}  // namespace ratslam
