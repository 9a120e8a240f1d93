#include "ratslam/dataset/trajectory_io.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace ratslam {
namespace {

template <class WritePose>
void writeLines(const std::string& path, const std::vector<StampedPose3>& trajectory, WritePose writePose) {
  std::ofstream file(path);
  file.precision(std::numeric_limits<double>::max_digits10);
  for (const StampedPose3& stamped : trajectory) writePose(file, stamped);
  file.flush();
  if (!file) throw std::runtime_error(path + ": cannot write this trajectory");
}

}  // namespace

std::string formatStamp(Stamp stamp) {
  const Stamp billion = 1000000000;
  const bool negative = stamp < 0;
  const Stamp magnitude = negative ? -stamp : stamp;
  char text[40];
  std::snprintf(text, sizeof text, "%s%lld.%09lld", negative ? "-" : "",
                static_cast<long long>(magnitude / billion), static_cast<long long>(magnitude % billion));
  return text;
}

void writeTum(const std::string& path, const std::vector<StampedPose3>& trajectory) {
  writeLines(path, trajectory, [](std::ostream& out, const StampedPose3& stamped) {
    const Eigen::Vector3d t = stamped.pose.translation();
    const Eigen::Quaterniond q(stamped.pose.linear());
    out << formatStamp(stamped.stamp) << ' ' << t.x() << ' ' << t.y() << ' ' << t.z() << ' ' << q.x() << ' '
        << q.y() << ' ' << q.z() << ' ' << q.w() << '\n';
  });
}

void writeKitti(const std::string& path, const std::vector<StampedPose3>& trajectory) {
  writeLines(path, trajectory, [](std::ostream& out, const StampedPose3& stamped) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        out << stamped.pose.matrix()(row, column) << (row == 2 && column == 3 ? '\n' : ' ');
      }
    }
  });
}

std::vector<Eigen::Isometry3d> readKittiPoses(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot open this file of poses");
  std::vector<Eigen::Isometry3d> poses;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    std::istringstream words(line);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 12; ++i) words >> pose.matrix()(i / 4, i % 4);
    std::string rest;
    if (!words || words >> rest || !pose.matrix().allFinite()) {
      throw std::runtime_error(path + ":" + std::to_string(number) +
                               ": a pose has 12 numbers, the rows of [R|t]");
    }
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace ratslam
