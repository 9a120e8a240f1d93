/// Interface between rendering and file formats: a sink receives the frames of a synthetic drive.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "ratslam/common/stamp.h"
#include "ratslam/odometry/odometry.h"
#include "town/camera.h"
#include "town/town_options.h"

namespace ratslam {

struct GpsFix {
  double latitude = 0.0;   ///< WGS-84 [deg]
  double longitude = 0.0;  ///< [deg]
  double altitude = 0.0;   ///< above the ellipsoid [m]
  double accuracy = 0.0;   ///< standard deviation per axis [m]
  double bearing = 0.0;    ///< clockwise from north [deg], in [0, 360)
  double speed = 0.0;      ///< over ground [m/s]
};

struct ImuSample {
  Stamp stamp = 0;                                         ///< from the start of the drive
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< specific force in camera axes [m/s^2]
  Eigen::Vector3d angular_rate = Eigen::Vector3d::Zero();  ///< in camera axes [rad/s]
};

/// All data of a drive at the time of one image. Stamps count from the start of the drive.
struct TownFrame {
  int index = 0;
  Stamp stamp = 0;
  cv::Mat image;                                                     ///< CV_8U
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();  ///< truth: x right, y down, z forward
  std::optional<OdometrySample> wheel;                               ///< if wheel odometry was requested
  std::optional<GpsFix> gps;                                         ///< at least a second after the last
  std::vector<ImuSample> imu;                                        ///< since the frame before, 100 Hz
};

/// For sinks, before they begin: what is there already is not overwritten, and no drive is mixed with another.
/// @throws std::invalid_argument naming the path.
void expectAbsent(const std::string& path);

class TownSink {
 public:
  virtual ~TownSink() = default;
  virtual void add(const TownFrame& frame) = 0;
  /// Called once after the last frame, also when a drive was ended early.
  virtual void finish() = 0;
};

/// KITTI odometry layout: image_0/%06d.png (or .jpg), times.txt, calib.txt (P0 to P3 alike: one camera),
/// poses.txt, and with wheel odometry odometry.csv (frame,stamp,linear_x,angular_z). Android recorder layout:
/// yy-MM-dd-HH-mm-ss/images/<ms>.jpeg, data_image.txt, data_imu.txt (camera axes), data_gps.txt; beside that
/// folder calibration.yaml and truth.tum (the camera's pose, world axes x east, y down, z north).
/// @throws std::invalid_argument if the folder cannot be made, one of these files is there already, or an option has no
/// effect on them.
/// @throws std::runtime_error (from add and finish) if a file cannot be written.
std::unique_ptr<TownSink> makeFolderSink(const TownOptions& options);

}  // namespace ratslam
