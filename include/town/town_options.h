/// Options of `ratslam_town`. The command line, its checks and its help are derived from visitFields().
#pragma once

#include <string>
#include <vector>

#include "ratslam/common/params.h"
#include "town/camera.h"

namespace ratslam {

struct TownOptions {
  std::string out;               ///< folder or bag file that the sink writes
  std::string layout = "kitti";  ///< kitti or recorder
  int frames = -1;               ///< -1: 600, or all poses of the trajectory
  int seed = 1;
  std::string trajectory;           ///< KITTI poses to drive along; empty: the built-in circuit
  std::string times;                ///< times of the trajectory's poses
  std::string size = "1241x376";    ///< [px]
  std::vector<double> calibration;  ///< fx fy cx cy; empty: KITTI's at this size
  std::vector<double> distortion;   ///< k1 k2 p1 p2 k3; empty: none
  int jpeg_quality = 0;             ///< 0: PNG (in the recorder layout: 90)
  bool exposure = false;
  double other_light_after = -1.0;  ///< [s]; negative: never
  bool identical_houses = false;
  double noise = 0.0;  ///< standard deviation [grey values]
  int moving_cars = 0;
  /// Scale error, sigma of speed [m/s], sigma of yaw rate [rad/s]; empty: none.
  std::vector<double> wheel_noise;
  /// Sigma of speed / speed, sigma of the turn per metre [deg]; empty: none.
  std::vector<double> wheel_slip;
  bool wheel_covariance = false;  ///< the wheel odometry states its covariance
  double gps_noise = 0.0;         ///< standard deviation per axis [m]
  /// Latitude, longitude [deg], height [m] of the first pose.
  std::vector<double> origin{49.0336, 8.3949, 112.0};
  double start = 1600000000.0;  ///< Unix time of the first frame where stamps are absolute [s]
  int threads = 1;

  template <class Visitor>
  void visitFields(Visitor&& visit) {
    visit("out", out, Bounds{}, "where to write (required)");
    visit("layout", layout, Bounds{},
          "kitti: image_0, times.txt, calib.txt, poses.txt; recorder: Android data set recorder");
    visit("frames", frames, Bounds{-1, 1e6}, "frames to render; -1: 600, or the whole trajectory");
    visit("seed", seed, Bounds{0, 2147483647}, "seed of the random numbers for town, traffic and noise");
    visit("trajectory", trajectory, Bounds{},
          "file of KITTI poses to drive along; the town is built along them");
    visit("times", times, Bounds{}, "file with the times of the trajectory's poses [s]; without it 10 Hz");
    visit("size", size, Bounds{}, "size of the images, WxH [px]");
    visit("calibration", calibration, Bounds{}, "fx,fy,cx,cy [px]; without it KITTI's, scaled to the size");
    visit("distortion", distortion, Bounds{}, "k1,k2,p1,p2,k3 of the lens (plumb bob)");
    visit("jpeg_quality", jpeg_quality, Bounds{0, 100},
          "write JPEG of this quality; 0: PNG (recorder layout: JPEG 90)");
    visit("exposure", exposure, Bounds{}, "let the exposure drift and jump");
    visit("other_light_after", other_light_after, Bounds{-1, 1e6},
          "time after which the light changes: darker, and from the side [s]; -1: never");
    visit("identical_houses", identical_houses, Bounds{},
          "repeat one house every 12 m, with nothing else beside the road");
    visit("noise", noise, Bounds{0, 100}, "standard deviation of pixel noise [grey values]");
    visit("moving_cars", moving_cars, Bounds{0, 10000},
          "moving cars: every fourth drives in front, the others come towards the camera");
    visit("wheel_noise", wheel_noise, Bounds{},
          "scale error,sigma of speed [m/s],sigma of yaw rate [rad/s]: write wheel odometry with this noise");
    visit("wheel_slip", wheel_slip, Bounds{},
          "sigma of speed / speed,sigma of the turn per metre [deg]: write wheel odometry with this slip");
    visit("wheel_covariance", wheel_covariance, Bounds{},
          "write the covariance of the wheel odometry, the scale error included");
    visit("gps_noise", gps_noise, Bounds{0, 1000}, "standard deviation of GPS fixes per axis [m]");
    visit("origin", origin, Bounds{}, "latitude,longitude [deg],height [m] of the first pose");
    visit("start", start, Bounds{1, 4e9}, "Unix time of the first frame where stamps are absolute [s]");
    visit("threads", threads, Bounds{1, 64}, "threads; they do not change the output");
  }
  /// @throws std::invalid_argument naming option, value and what is allowed.
  void validate() const;
  bool writesBag() const;  ///< whether `out` is the name of a bag
  /// What is given must show in the files: a layout has no place for every sensor.
  /// @throws std::invalid_argument naming option, value and what has a place for it.
  void expectEffects() const;
  bool wheelOdometry() const { return !wheel_noise.empty() || !wheel_slip.empty(); }
  /// Camera of the given size, calibration and distortion. @throws std::invalid_argument as validate().
  TownCamera camera() const;
};

/// Reads a command line of `--name value` or `--name=value`. In names - and _ are the same. A bool needs no
/// value.
/// @throws std::invalid_argument for unknown names, missing or malformed values, and as validate().
TownOptions parseTownOptions(const std::vector<std::string>& arguments);

/// Text of the help: one line per option, with its default.
std::string townUsage();

}  // namespace ratslam
