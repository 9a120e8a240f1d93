// Opens whatever a user may call a recording.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "ratslam/camera/camera_model.h"
#include "ratslam/camera/image_decoding.h"
#include "ratslam/dataset/recording.h"

namespace ratslam {

struct RecordingOptions {
  std::string image_topic;     ///< of a bag; empty: the only one it has
  std::string odometry_topic;  ///< of a bag; empty: the only one it has
  bool with_odometry = false;  ///< hand out the bag's odometry among the images
  ImageLimits limits;
  int rotate_deg = 0;  ///< turn the images of a recorder's folder clockwise
};

/// A KITTI sequence folder, an Android recorder's folder or a bag.
/// @throws std::runtime_error saying what is missing, or what a recording may be
std::unique_ptr<Recording> openRecording(const std::string& path, const RecordingOptions& options);

/// The calibration that comes with a recording: calib.txt of a KITTI folder, camera_info of a bag.
/// @throws std::runtime_error naming what is malformed
std::optional<CameraModel> cameraOf(const Recording& recording);

}  // namespace ratslam
