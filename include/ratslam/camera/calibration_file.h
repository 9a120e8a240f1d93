/// A camera's intrinsics in a file: hand-written (image_width, image_height, fx, fy, cx, cy and the plumb bob
/// distortion k1, k2, p1, p2, k3, as config/calibration/phone_example.yaml), or as ROS's camera_calibration and
/// OpenCV leave it (camera_matrix, distortion_model, distortion_coefficients). scripts/recorder_to_bag reads the
/// same.
#pragma once

#include <string>

#include "ratslam/camera/camera_model.h"

namespace ratslam {

/// @throws std::runtime_error or std::invalid_argument naming file, key, value and what would be right
CameraModel readCalibration(const std::string& path);

}  // namespace ratslam
