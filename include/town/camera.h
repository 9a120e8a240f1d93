/// The camera of a synthetic drive: a pinhole with the plumb-bob lens of OpenCV and of ROS' CameraInfo.
#pragma once

#include <array>

namespace ratslam {

struct TownCamera {
  int width = 1241;                    ///< [px]
  int height = 376;                    ///< [px]
  double fx = 718.856;                 ///< [px]
  double fy = 718.856;                 ///< [px]
  double cx = 607.1928;                ///< [px], the centre of the leftmost column is 0
  double cy = 185.2157;                ///< [px], the centre of the top row is 0
  std::array<double, 5> distortion{};  ///< k1 k2 p1 p2 k3

  /// The left grey camera of KITTI 00 at another size: square pixels, the same horizontal angle of view and
  /// the horizon at the same share of the height.
  static TownCamera kittiLike(int width, int height);
  bool distorted() const;
  /// @throws std::invalid_argument naming key, value and bound.
  void validate() const;
};

}  // namespace ratslam
