/// The path of a synthetic drive, and the roads it needs.
///
/// Truth convention (KITTI): poses of the camera, x right, y down, z forward, in the axes of the first pose
/// of the path. The camera rides 1.65 m above the road.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "ratslam/common/stamp.h"
#include "town/road_field.h"

namespace ratslam {

constexpr double kCameraHeight = 1.65;  ///< above the road [m]

struct DrivePose {
  Stamp stamp = 0;  ///< from the start of the drive
  Eigen::Isometry3d T_world_camera = Eigen::Isometry3d::Identity();
};

struct Drive {
  std::vector<DrivePose> poses;
  std::vector<std::vector<RoadPoint>> roads;  ///< the driven road first
};

/// A drive through a grid of blocks, at 10 Hz and 5 to 11.5 m/s. It repeats a circuit of 14 streets without end. Within
/// its first 600 frames it returns three times to a known street in the same direction (each time after it has left the
/// known path), and once in the opposite direction. The roads do not depend on the number of frames.
/// @throws std::invalid_argument for less than one frame.
Drive planTownDrive(int frames);

/// A drive along recorded poses. All of them make the road; the first `frames` (0: all) are driven.
/// @param poses_file KITTI poses: 12 numbers a line, a 3x4 matrix by rows.
/// @param times_file seconds, one a line; empty: 10 Hz.
/// @throws std::invalid_argument naming file and line where one is malformed, not a rigid motion, or where times do not
/// increase, lie outside [0, 4e9] s, or more than 1e6 s after the first. @throws std::runtime_error as readLines does
Drive loadDrive(const std::string& poses_file, const std::string& times_file, int frames);

/// Puts the camera of a recorded drive at its height above the town's road. When a drive returns to a place, the recorded
/// heights can differ by metres, but the town has only one road. The camera follows that road, and keeps the vertical
/// motion over distances of less than about 10 m. Horizontal positions and rotations do not change.
void settleOnRoad(Drive& drive, const RoadField& roads);

}  // namespace ratslam
