/// Recorded drives for the tests of the experience map: OpenRatSLAM's reference run over KITTI 00, and
/// KITTI's true trajectories. Tests skip where the data are absent.
#pragma once

#include <Eigen/Geometry>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "oracle/experience_map_drive.h"
#include "ratslam/events.h"
#include "ratslam/experience_map/experience_map.h"

namespace ratslam {

inline std::string dataFolder() {
  const char* folder = std::getenv("RATSLAM_DATA");
  return folder != nullptr ? folder : RATSLAM_SOURCE_DIR "/../shared/data";
}

/// Rows of a table of numbers, separated by commas or blanks; lines that do not start with a number are left
/// out.
inline std::vector<std::vector<double>> readTable(const std::string& path) {
  std::vector<std::vector<double>> rows;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::istringstream in(line);
    std::vector<double> row;
    for (double value = 0.0; in >> value;) row.push_back(value);
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

/// The reference run: the true planar odometry and the decisions of OpenRatSLAM's pose cells. The first step
/// has no motion.
inline std::vector<DriveStep> readReferenceDrive() {
  const auto odometry = readTable(dataFolder() + "/openratslam_reference/odometry.csv");
  const auto decisions = readTable(dataFolder() + "/openratslam_reference/pose_cells.csv");
  std::vector<DriveStep> drive(std::min(odometry.size(), decisions.size()));
  for (std::size_t k = 0; k < drive.size(); ++k) {
    DriveStep& step = drive[k];
    step.end = stampFromSeconds(odometry[k][1]);
    if (k > 0) {
      step.motion.dt = odometry[k][1] - odometry[k - 1][1];
      step.motion.forward = odometry[k][2] * step.motion.dt;
      step.motion.rotation = odometry[k][3] * step.motion.dt;
    }
    step.action.stamp = step.end;
    step.action.kind = static_cast<ActionKind>(static_cast<std::uint32_t>(decisions[k][4]));
    step.action.src_id = static_cast<std::uint32_t>(decisions[k][5]);
    step.action.dest_id = static_cast<std::uint32_t>(decisions[k][6]);
  }
  return drive;
}

/// Camera positions of a KITTI trajectory, one column a frame.
inline Eigen::Matrix3Xd readKittiPositions(const std::string& path) {
  const auto rows = readTable(path);
  Eigen::Matrix3Xd positions(3, static_cast<Eigen::Index>(rows.size()));
  for (Eigen::Index k = 0; k < positions.cols(); ++k) {
    const auto& row = rows[static_cast<std::size_t>(k)];
    positions.col(k) = Eigen::Vector3d(row[3], row[7], row[11]);
  }
  return positions;
}

inline Eigen::Matrix3Xd positionsOf(const std::vector<StampedPose>& path) {
  Eigen::Matrix3Xd positions(3, static_cast<Eigen::Index>(path.size()));
  for (Eigen::Index k = 0; k < positions.cols(); ++k) {
    const MapPose& pose = path[static_cast<std::size_t>(k)].pose;
    positions.col(k) = Eigen::Vector3d(pose.x, pose.y, pose.z);
  }
  return positions;
}

/// Mean absolute position error after alignment by rotation, translation and scale (Umeyama, 1991) [m].
inline double meanApe(const Eigen::Matrix3Xd& estimate, const Eigen::Matrix3Xd& truth) {
  const Eigen::Matrix4d similarity = Eigen::umeyama(estimate, truth, true);
  const Eigen::Matrix3Xd aligned = (similarity.topLeftCorner<3, 3>() * estimate).colwise() +
                                   Eigen::Vector3d(similarity.topRightCorner<3, 1>());
  return (aligned - truth).colwise().norm().mean();
}

}  // namespace ratslam
