#include "ratslam/camera/calibration_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace ratslam {
namespace {

const std::string kWhole = "image_width: 1280\nimage_height: 960\nfx: 1000.5\nfy: 1001\ncx: 640\ncy: 480\n";

CameraModel read(const std::string& text) {
  const auto path = std::filesystem::temp_directory_path() / "calibration_file_test.yaml";
  std::ofstream(path) << text;
  return readCalibration(path.string());
}

std::string complaint(const std::string& text) {
  try {
    read(text);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

TEST(CalibrationFile, GivesTheCameraAndItsDistortionWhereThereIsOne) {
  const CameraModel plain = read(kWhole + "k1: 0.0\n");
  EXPECT_EQ(plain.width, 1280);
  EXPECT_EQ(plain.fx, 1000.5);
  EXPECT_EQ(plain.model, LensModel::kNone);
  const CameraModel bent = read(kWhole + "k1: -0.2\nk2: 0.05\np2: 0.001  # tangential\n");
  EXPECT_EQ(bent.model, LensModel::kPlumbBob);
  EXPECT_EQ(bent.coefficients, (std::vector<double>{-0.2, 0.05, 0.0, 0.001, 0.0}));
  EXPECT_EQ(readCalibration(std::string(RATSLAM_SOURCE_DIR) + "/config/calibration/phone_example.yaml").width,
            1280);
}

TEST(CalibrationFile, CoefficientsThatNoLensHasAreDoubted) {
  for (const char* real :
       {"k1: -0.2\nk2: 0.05\n", "k1: -0.37\nk2: 0.2\np1: 0.001\nk3: -0.07\n", "k1: 0.3\n"}) {
    EXPECT_FALSE(read(kWhole + real).doubt().has_value()) << real;
  }
  for (const char* none : {"k1: 9e9\n", "k1: -50\n", "k3: 1e9\n", "p1: 40\n"}) {
    EXPECT_NE(read(kWhole + none).doubt().value_or("").find("distortion coefficients leave nothing"),
              std::string::npos)
        << none;
  }
}

const std::string kRos =
    "image_width: 1280\nimage_height: 960\ncamera_name: phone\n"
    "camera_matrix: {rows: 3, cols: 3, data: [1000.5, 0, 640, 0, 1001, 480, 0, 0, 1]}\n"
    "distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.2, 0.05, 0, "
    "0.001, 0]\n";

std::string changed(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(CalibrationFile, WhatRosAndOpenCvLeaveIsRead) {
  const std::string opencv = "%YAML:1.0\n---\n" + changed(kRos, "matrix: {", "matrix: !!opencv-matrix {");
  for (const std::string& text : {kRos, "\xEF\xBB\xBF" + kRos, opencv}) {
    const CameraModel camera = read(text);
    EXPECT_EQ(camera.width, 1280);
    EXPECT_EQ(camera.fy, 1001.0);
    EXPECT_EQ(camera.cx, 640.0);
    EXPECT_EQ(camera.model, LensModel::kPlumbBob);
    EXPECT_EQ(camera.coefficients, (std::vector<double>{-0.2, 0.05, 0.0, 0.001, 0.0}));
  }
  EXPECT_EQ(read(changed(kRos, "plumb_bob", "equidistant")).coefficients.size(), 4U)
      << "trailing zeros are dropped";
  EXPECT_EQ(read(changed(kRos, "-0.2, 0.05, 0, 0.001, 0", "0, 0, 0, 0, 0")).model, LensModel::kNone);
}

TEST(CalibrationFile, FaultsOfThatFormAreNamed) {
  const auto refused = [](const std::string& from, const std::string& to, const std::string& words) {
    const std::string said = complaint(changed(kRos, from, to));
    EXPECT_NE(said.find(words), std::string::npos) << said;
    EXPECT_EQ(said.find('\n'), std::string::npos) << said;
  };
  refused("plumb_bob", "mirror", "mirror");
  refused("[1000.5, 0,", "[1000.5, -7,", "camera_matrix[1] (skew): value -7");
  refused("[1000.5, 0,", "[1000.5,", "camera_matrix");
  refused("[1000.5", "[wide", "'wide' is not a finite number");
  refused("[1000.5", "[0", "camera fx: value 0");
  refused("[1000.5", "[1e-310", "camera fx");
  refused("image_width: 1280", "image_width: 1e9", "image_width: value 1000000000");
  refused("image_width: 1280\n", "", "no image_width");
  refused("0.001, 0]", "0.001, 0, 0.3]", "number of distortion coefficients");
  refused("data: [1000.5", "date: [1000.5", "camera_matrix: 'data: [...]' is expected");
}

TEST(CalibrationFile, FaultsAreNamed) {
  EXPECT_NE(complaint("image_width: 1280\n").find("calibration_file_test.yaml: no image_height"),
            std::string::npos);
  EXPECT_NE(complaint(kWhole + "k4: 1\n").find("k4"), std::string::npos);
  EXPECT_NE(complaint(kWhole + "k1: much\n").find("k1"), std::string::npos);
  std::string none = kWhole;
  none.replace(none.find("1000.5"), 6, "0");
  EXPECT_NE(complaint(none).find("fx: value 0 is not allowed"), std::string::npos);
}

TEST(LensModel, ANameThatCannotBePrintedIsToldByItsLength) {
  try {
    lensModelFromName("plumb\nbob\xff");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("of 10 unprintable bytes"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace ratslam
