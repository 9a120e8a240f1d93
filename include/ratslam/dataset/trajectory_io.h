/// Trajectory files in the formats TUM and KITTI.
///
/// TUM: one line `stamp x y z qx qy qz qw` per pose. The stamp [s] has nine decimals, so that it is exact. KITTI: one
/// line per pose with the 12 numbers of the 3x4 matrix [R|t], row by row, without stamps. Numbers have 17 significant
/// digits: reading gives the same doubles, and equal results give equal bytes.
#pragma once

#include <Eigen/Geometry>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "ratslam/common/stamp.h"

namespace ratslam {

struct StampedPose3 {
  Stamp stamp = 0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};

/// The stamp of a time in seconds. The form of formatStamp is exact to the nanosecond. More digits are rounded, and
/// other notations have the precision of a double. @return none if the text is not one finite number
std::optional<Stamp> parseStamp(const std::string& text);

void writeTum(std::ostream& file, const std::vector<StampedPose3>& trajectory);
void writeKitti(std::ostream& file, const std::vector<StampedPose3>& trajectory);

/// @throws std::runtime_error naming the file if it cannot be written; an old file remains then
void writeTum(const std::string& path, const std::vector<StampedPose3>& trajectory);
/// The same as KITTI poses.
void writeKitti(const std::string& path, const std::vector<StampedPose3>& trajectory);

/// Divides a list of stamped values into parts with ascending stamps: a new part begins where time went back, as in a
/// looped bag. There is at least one part, which may be empty.
template <class Stamped>
std::vector<std::vector<Stamped>> stretchesOf(const std::vector<Stamped>& values) {
  std::vector<std::vector<Stamped>> stretches(1);
  for (const Stamped& value : values) {
    if (!stretches.back().empty() && value.stamp <= stretches.back().back().stamp) stretches.emplace_back();
    stretches.back().push_back(value);
  }
  return stretches;
}
/// File name of part `number`, counted from 0: run.tum, run_2.tum, run_3.tum ...
std::string stretchName(const std::string& path, std::size_t number);

/// Reads poses with 12 numbers per line. @throws std::runtime_error naming file, line and reason
std::vector<Eigen::Isometry3d> readKittiPoses(const std::string& path);

}  // namespace ratslam
