/// Trajectories as the field's tools read them.
///
/// TUM: a line `stamp x y z qx qy qz qw` a pose (stamp [s] with nine digits after the point, so that no stamp
/// is rounded). KITTI: a line of the 12 numbers of the 3x4 matrix [R|t], row by row, a pose; stamps are lost.
/// Numbers are written with 17 significant digits: reading them back gives the same doubles, and two runs
/// with equal results leave equal bytes.
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

/// A stamp as seconds with nine decimals, exactly.
std::string formatStamp(Stamp stamp);
/// The stamp of a time in seconds: what formatStamp wrote, to the last nanosecond; more digits are rounded,
/// and other ways to write a number taken as far as a double goes. @return none where the text is not one
/// finite number
std::optional<Stamp> parseStamp(const std::string& text);

void writeTum(std::ostream& file, const std::vector<StampedPose3>& trajectory);
void writeKitti(std::ostream& file, const std::vector<StampedPose3>& trajectory);

/// @throws std::runtime_error naming the file where it cannot be written; what was there stays then
void writeTum(const std::string& path, const std::vector<StampedPose3>& trajectory);
/// The same as KITTI poses.
void writeKitti(const std::string& path, const std::vector<StampedPose3>& trajectory);

/// The parts of a list of stamped values in which stamps rise: where time went back, as in a looped bag, a new part
/// begins. At least one, which may be empty.
template <class Stamped>
std::vector<std::vector<Stamped>> stretchesOf(const std::vector<Stamped>& values) {
  std::vector<std::vector<Stamped>> stretches(1);
  for (const Stamped& value : values) {
    if (!stretches.back().empty() && value.stamp <= stretches.back().back().stamp) stretches.emplace_back();
    stretches.back().push_back(value);
  }
  return stretches;
}
/// Name of a stretch's file, counted from 0: run.tum, run_2.tum, run_3.tum ...
std::string stretchName(const std::string& path, std::size_t number);

/// Reads poses of 12 numbers a line. @throws std::runtime_error naming file, line and reason
std::vector<Eigen::Isometry3d> readKittiPoses(const std::string& path);

}  // namespace ratslam
