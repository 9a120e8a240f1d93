/// What the tests of the town share.
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "town/drive.h"
#include "town/town.h"

namespace ratslam {

inline Eigen::Isometry3d poseAt(double x, double y, double z, double bearing) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(x, y, z);
  pose.linear() = Eigen::AngleAxisd(bearing, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return pose;
}

/// Mean absolute difference of two 8-bit images.
inline double difference(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total());
}

inline bool equalBytes(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && cv::norm(a, b, cv::NORM_INF) == 0.0;
}

/// The built-in town, built once for all tests of a program: it takes half a second.
class TownFixture {
 public:
  static constexpr int kFrames = 600;
  TownFixture() : drive(planTownDrive(kFrames)), town(drive.roads, 1) {}
  Drive drive;
  Town town;
};

/// A folder that goes when the test ends.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  const std::string& path() const { return path_; }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }

 private:
  std::string path_;
};

/// What a callable throws as std::invalid_argument; empty if nothing.
template <class Callable>
std::string complaint(Callable&& callable) {
  try {
    callable();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

}  // namespace ratslam
