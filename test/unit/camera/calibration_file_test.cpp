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

CameraModel withCentre(int width, int height, double cx, double cy) {
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 0.7 * width;
  camera.cx = cx;
  camera.cy = cy;
  return camera;
}

TEST(CalibrationFile, OneForImagesOfAnotherSizeIsDoubted) {
  for (const double factor : {0.4, 0.5, 0.667, 0.72, 0.75, 0.8, 1.25, 1.333, 1.5, 1.66, 2.0, 3.0}) {
    for (const auto& [x, y] : {std::pair(0.5, 0.5), std::pair(0.489, 0.493), std::pair(0.51, 0.53)}) {
      const CameraModel scaled =
          withCentre(static_cast<int>(640 * factor), static_cast<int>(480 * factor), 640 * x, 480 * y);
      const std::string doubt = scaled.doubt().value_or("");
      EXPECT_NE(doubt.find("images of another size"), std::string::npos) << factor << ' ' << x << ' ' << y;
    }
  }
  EXPECT_NE(withCentre(480, 360, 320, 240).doubt().value_or("").find("of about 640x480?"), std::string::npos);
}

TEST(CalibrationFile, RealPrincipalPointsAreNotDoubted) {
  for (const CameraModel& real :
       {withCentre(1241, 376, 607.19, 185.22), withCentre(752, 480, 367.215, 248.375),
        withCentre(640, 480, 318.6, 255.3), withCentre(1600, 900, 816.3, 491.5),
        withCentre(1920, 1280, 935.2, 635.1), withCentre(640, 480, 640 * 0.58, 480 * 0.58),
        withCentre(640, 480, 640 * 0.43, 480 * 0.43)}) {
    EXPECT_FALSE(real.doubt().has_value()) << real.cx << ' ' << real.cy << ": " << *real.doubt();
  }
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
