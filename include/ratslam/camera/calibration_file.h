/// Reads a camera's intrinsics from a file. There are two forms: hand-written with image_width, image_height, fx, fy,
/// cx, cy and the plumb bob distortion k1, k2, p1, p2, k3 (like config/calibration/phone_example.yaml), or written by
/// ROS's camera_calibration or OpenCV (camera_matrix, distortion_model, distortion_coefficients).
/// scripts/recorder_to_bag reads the same forms.
#pragma once

#include <string>

#include "ratslam/camera/camera_model.h"

namespace ratslam {

/// @throws std::runtime_error or std::invalid_argument naming file, key, value and what would be right
CameraModel readCalibration(const std::string& path);

}  // namespace ratslam
