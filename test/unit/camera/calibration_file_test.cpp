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

TEST(CalibrationFile, FaultsAreNamed) {
  EXPECT_NE(complaint("image_width: 1280\n").find("calibration_file_test.yaml: no image_height"),
            std::string::npos);
  EXPECT_NE(complaint(kWhole + "k4: 1\n").find("k4"), std::string::npos);
  EXPECT_NE(complaint(kWhole + "k1: much\n").find("k1"), std::string::npos);
  std::string none = kWhole;
  none.replace(none.find("1000.5"), 6, "0");
  EXPECT_NE(complaint(none).find("fx: value 0 is not allowed"), std::string::npos);
}

}  // namespace
}  // namespace ratslam
