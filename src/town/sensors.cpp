#include "town/sensors.h"

#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"
#include "town/hash.h"

namespace ratslam {
namespace {

constexpr double kGravity = 9.80665;  // [m/s^2]

/// Radiance in the evening. @param across 0 at the left edge of the image, 1 at the right
float inOtherLight(float radiance, float across) {
  constexpr float kWhite = 255.0F;
  constexpr float kGamma = 1.7F;
  constexpr float kShade = 0.5F;  // what is left of the light at the right edge
  return kWhite * std::pow(std::max(radiance, 0.0F) / kWhite, kGamma) * (1.0F - (1.0F - kShade) * across);
}

/// Bearing of the optical axis, clockwise from north seen from above [rad].
double bearing(const Eigen::Isometry3d& pose) {
  const Eigen::Vector3d forward = pose.linear().col(2);
  return std::atan2(forward.x(), forward.z());
}

}  // namespace

Exposure exposureAt(double seconds, std::uint64_t seed) {
  HashStream random(hashOf(seed, 70));
  const double phase = random.range(0.0, 2.0 * kPi);
  constexpr double kHold = 9.0;      // [s]
  constexpr double kSettling = 0.3;  // [s]
  const auto level = [&](double window) {
    return window < 1.0 ? 1.0
                        : 0.75 + 0.5 * unitFromHash(hashOf(seed, 71, static_cast<std::uint64_t>(window)));
  };
  const double window = std::floor(seconds / kHold);
  const double settled = std::exp(-(seconds - window * kHold) / kSettling);
  const double jump = level(window) + (level(window - 1.0) - level(window)) * settled;
  const double drift = 1.0 + 0.12 * std::sin(2.0 * kPi * seconds / 23.0 + phase) +
                       0.06 * std::sin(2.0 * kPi * seconds / 7.3 + 2.0 * phase);
  return {jump * drift, 6.0 * std::sin(2.0 * kPi * seconds / 31.0 + 3.0 * phase)};
}

cv::Mat expose(const cv::Mat& radiance, const Exposure& exposure, double sigma, std::uint64_t frame_seed) {
  cv::Mat image(radiance.size(), CV_8U);
  const auto gain = static_cast<float>(exposure.gain);
  const auto offset = static_cast<float>(exposure.offset);
  for (int row = 0; row < image.rows; ++row) {
    const float* const in = radiance.ptr<float>(row);
    std::uint8_t* const out = image.ptr<std::uint8_t>(row);
    for (int column = 0; column < image.cols; ++column) {
      float light = in[column];
      if (exposure.other_light) {
        light = inOtherLight(light, static_cast<float>(column) / static_cast<float>(image.cols));
      }
      float value = gain * light + offset;
      if (sigma > 0.0) {
        const std::uint64_t pixel =
            static_cast<std::uint64_t>(row) << 32 | static_cast<std::uint64_t>(column);
        value += static_cast<float>(sigma * normalFromHash(hashOf(frame_seed, pixel)));
      }
      out[column] = static_cast<std::uint8_t>(std::clamp(value, 0.0F, 255.0F) + 0.5F);
    }
  }
  return image;
}

Eigen::Vector3d geodeticFromEnu(const Eigen::Vector3d& origin, const Eigen::Vector3d& enu) {
  constexpr double kA = 6378137.0;  // WGS-84 ellipsoid [m]
  constexpr double kF = 1.0 / 298.257223563;
  constexpr double kE2 = kF * (2.0 - kF);
  const double latitude0 = degreesToRadians(origin.x());
  const double longitude0 = degreesToRadians(origin.y());
  const double s = std::sin(latitude0);
  const double c = std::cos(latitude0);
  const auto radius = [&](double sine) { return kA / std::sqrt(1.0 - kE2 * sine * sine); };
  // In the meridian plane of the origin: p from the axis, q along it; east is at right angles to the plane.
  const double p = (radius(s) + origin.z()) * c - s * enu.y() + c * enu.z();
  const double q = (radius(s) * (1.0 - kE2) + origin.z()) * s + c * enu.y() + s * enu.z();
  const double from_axis = std::hypot(p, enu.x());
  double latitude = std::atan2(q, from_axis * (1.0 - kE2));
  double height = 0.0;
  for (int i = 0; i < 8; ++i) {  // converges by a factor of e^2 = 0.007 a step
    const double n = radius(std::sin(latitude));
    height = from_axis / std::cos(latitude) - n;
    latitude = std::atan2(q, from_axis * (1.0 - kE2 * n / (n + height)));
  }
  const double longitude = wrapAngle(longitude0 + std::atan2(enu.x(), p));
  return {radiansToDegrees(latitude), radiansToDegrees(longitude), height};
}

DriveSensors::DriveSensors(const Drive& drive, const TownOptions& options)
    : drive_(drive), options_(options), seed_(hashOf(static_cast<std::uint64_t>(options.seed), 80)) {}

double DriveSensors::secondsBefore(std::size_t frame) const {
  return secondsBetween(drive_.poses[frame - 1].stamp, drive_.poses[frame].stamp);
}

OdometrySample DriveSensors::wheel(std::size_t frame) const {
  OdometrySample sample;
  sample.stamp = drive_.poses[frame].stamp;
  if (frame == 0) return sample;
  const Eigen::Isometry3d& before = drive_.poses[frame - 1].T_world_camera;
  const Eigen::Isometry3d& now = drive_.poses[frame].T_world_camera;
  const double dt = secondsBefore(frame);
  const Eigen::Vector3d step = now.translation() - before.translation();
  const double sign = step.dot(now.linear().col(2)) < 0.0 ? -1.0 : 1.0;
  sample.speed = sign * step.norm() / dt;
  sample.yaw_rate = -wrapAngle(bearing(now) - bearing(before)) / dt;
  const auto given = [](const std::vector<double>& values, std::size_t i) {
    return values.empty() ? 0.0 : values[i];
  };
  const double scale_error = given(options_.wheel_noise, 0);
  const double sigma_speed =
      std::hypot(given(options_.wheel_noise, 1), given(options_.wheel_slip, 0) * sample.speed);
  const double sigma_turn = std::hypot(given(options_.wheel_noise, 2),
                                       degreesToRadians(given(options_.wheel_slip, 1)) * sample.speed);
  HashStream random(hashOf(seed_, 1, frame));
  sample.speed = sample.speed * (1.0 + scale_error) + sigma_speed * random.normal();
  sample.yaw_rate += sigma_turn * random.normal();
  if (options_.wheel_covariance) {
    // A robot on wheels moves neither sideways nor up, and does not tilt: there its error is small, not unknown.
    constexpr double kOther = 1e-6;
    sample.covariance = kOther * TwistCovariance::Identity();
    (*sample.covariance)(0, 0) += std::pow(sigma_speed, 2) + std::pow(scale_error * sample.speed, 2);
    (*sample.covariance)(5, 5) += std::pow(sigma_turn, 2);
  }
  return sample;
}

Eigen::Vector3d DriveSensors::velocity(std::size_t frame) const {
  const std::size_t a = frame == 0 ? 0 : frame - 1;
  const std::size_t b = std::min(frame + 1, drive_.poses.size() - 1);
  if (a == b) return Eigen::Vector3d::Zero();
  return (drive_.poses[b].T_world_camera.translation() - drive_.poses[a].T_world_camera.translation()) /
         secondsBetween(drive_.poses[a].stamp, drive_.poses[b].stamp);
}

GpsFix DriveSensors::gps(std::size_t frame) const {
  const Eigen::Vector3d place =
      drive_.poses[frame].T_world_camera.translation() - drive_.poses[0].T_world_camera.translation();
  HashStream random(hashOf(seed_, 2, frame));
  const double sigma = options_.gps_noise;
  Eigen::Vector3d enu(place.x(), place.z(), -place.y());
  for (int axis = 0; axis < 3; ++axis) enu[axis] += sigma * random.normal();
  const Eigen::Vector3d position =
      geodeticFromEnu({options_.origin[0], options_.origin[1], options_.origin[2]}, enu);
  const Eigen::Vector3d motion = velocity(frame);
  GpsFix fix;
  fix.latitude = position.x();
  fix.longitude = position.y();
  fix.altitude = position.z();
  fix.accuracy = sigma;
  fix.speed = std::hypot(motion.x(), motion.z());
  const double degrees = radiansToDegrees(fix.speed > 0.3 ? std::atan2(motion.x(), motion.z())
                                                          : bearing(drive_.poses[frame].T_world_camera));
  fix.bearing = std::fmod(std::round(degrees * 100.0) / 100.0 + 360.0, 360.0);  // receivers give hundredths
  return fix;
}

Eigen::Vector3d DriveSensors::acceleration(std::size_t frame) const {
  const std::size_t a = frame == 0 ? 0 : frame - 1;
  const std::size_t b = std::min(frame + 1, drive_.poses.size() - 1);
  if (a == b) return Eigen::Vector3d::Zero();
  return (velocity(b) - velocity(a)) / secondsBetween(drive_.poses[a].stamp, drive_.poses[b].stamp);
}

std::vector<ImuSample> DriveSensors::imu(std::size_t frame) const {
  std::vector<ImuSample> samples;
  constexpr Stamp kPeriod = 10000000;  // [ns]
  const Stamp now = drive_.poses[frame].stamp;
  const std::size_t from = frame == 0 ? 0 : frame - 1;
  const Stamp before = frame == 0 ? now - 1 : drive_.poses[from].stamp;
  const Eigen::Quaterniond start(drive_.poses[from].T_world_camera.linear());
  const Eigen::Quaterniond end(drive_.poses[frame].T_world_camera.linear());
  const Eigen::AngleAxisd turn(start.conjugate() * end);
  const Eigen::Vector3d rate = frame == 0 ? Eigen::Vector3d::Zero().eval()
                                          : (turn.angle() / secondsBefore(frame) * turn.axis()).eval();
  const Eigen::Vector3d a = acceleration(from);
  const Eigen::Vector3d b = acceleration(frame);
  for (Stamp stamp = (before / kPeriod + 1) * kPeriod - (frame == 0 ? kPeriod : 0); stamp <= now;
       stamp += kPeriod) {
    const double t = frame == 0 ? 1.0 : secondsBetween(before, stamp) / secondsBetween(before, now);
    const Eigen::Vector3d force = a + t * (b - a) - Eigen::Vector3d(0.0, kGravity, 0.0);
    samples.push_back({stamp, start.slerp(t, end).conjugate() * force, rate});
  }
  return samples;
}

}  // namespace ratslam
