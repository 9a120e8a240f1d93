/// Sensors of the car other than the camera's light: exposure and noise of the image, wheel odometry, GPS,
/// IMU. Each is a function of truth, time and seed.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "town/drive.h"
#include "town/town_options.h"
#include "town/town_sink.h"

namespace ratslam {

/// Exposure at a time: grey = gain * radiance + offset.
struct Exposure {
  double gain = 1.0;
  double offset = 0.0;
  bool other_light = false;  ///< in the evening: contrasts are others, and shade lies to the right
};

/// Slow drift of some 20%, and every 9 s a jump within +-25% that settles in about a second.
Exposure exposureAt(double seconds, std::uint64_t seed);

/// The image a sensor makes of light: exposure, noise (of standard deviation `sigma`, independent from pixel
/// to pixel and frame to frame), rounding. @param radiance CV_32F. @return CV_8U.
cv::Mat expose(const cv::Mat& radiance, const Exposure& exposure, double sigma, std::uint64_t frame_seed);

/// WGS-84 position of a point in the East-North-Up frame of an origin, exactly (by way of Earth-centred
/// coordinates).
/// @param origin latitude, longitude [deg], height [m]. @param enu [m].
/// @return latitude, longitude [deg], height [m].
Eigen::Vector3d geodeticFromEnu(const Eigen::Vector3d& origin, const Eigen::Vector3d& enu);

/// Readings of the other sensors. World x is east, z north, -y up.
class DriveSensors {
 public:
  /// @param drive must outlive the sensors.
  DriveSensors(const Drive& drive, const TownOptions& options);
  /// Planar odometry of the step that ends at a frame; at rest for the first.
  OdometrySample wheel(std::size_t frame) const;
  GpsFix gps(std::size_t frame) const;
  /// 100 Hz samples after the frame before and up to this frame.
  std::vector<ImuSample> imu(std::size_t frame) const;

 private:
  Eigen::Vector3d velocity(std::size_t frame) const;
  Eigen::Vector3d acceleration(std::size_t frame) const;
  double secondsBefore(std::size_t frame) const;

  const Drive& drive_;
  TownOptions options_;
  std::uint64_t seed_;
};

}  // namespace ratslam
