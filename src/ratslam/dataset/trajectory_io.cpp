#include "ratslam/dataset/trajectory_io.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "ratslam/common/atomic_file.h"
#include "ratslam/common/text_file.h"
#include "ratslam/dataset/csv.h"

namespace ratslam {
namespace {

/// Calls write(file, stamped) for each pose, with full precision of numbers.
template <class WritePose>
void writeLines(std::ostream& file, const std::vector<StampedPose3>& trajectory, WritePose write) {
  const auto precision = file.precision(std::numeric_limits<double>::max_digits10);
  for (const StampedPose3& stamped : trajectory) write(file, stamped);
  file.precision(precision);
}

}  // namespace

std::optional<Stamp> parseStamp(const std::string& written) {
  constexpr std::size_t kDecimals = 9;
  constexpr std::size_t kDigits = 10;
  constexpr Stamp kLatest = 9000000000;  // later times are no stamps [s]
  const std::string text = trimmed(written);
  const bool negative = !text.empty() && text.front() == '-';
  const std::string digits = text.substr(negative ? 1 : 0);
  const std::size_t point = std::min(digits.find('.'), digits.size());
  std::string whole = digits.substr(0, point);
  std::string decimals = point < digits.size() ? digits.substr(point + 1) : "";
  const bool plain = !whole.empty() && whole.size() <= kDigits &&
                     (whole + decimals).find_first_not_of("0123456789") == std::string::npos;
  if (!plain) {
    double seconds = 0.0;
    if (!parseNumber(text, seconds) || std::abs(seconds) > static_cast<double>(kLatest)) return std::nullopt;
    return stampFromSeconds(seconds);
  }
  if (std::stoll(whole) > kLatest) return std::nullopt;
  const bool round_up = decimals.size() > kDecimals && decimals[kDecimals] >= '5';
  decimals.resize(kDecimals, '0');
  const Stamp magnitude = std::stoll(whole + decimals) + (round_up ? 1 : 0);
  if (magnitude > kLatest * 1'000'000'000) return std::nullopt;
  return negative ? -magnitude : magnitude;
}

std::string stretchName(const std::string& path, std::size_t number) {
  if (number == 0) return path;
  const std::filesystem::path whole(path);
  const std::string name =
      whole.stem().string() + "_" + std::to_string(number + 1) + whole.extension().string();
  return (whole.parent_path() / name).string();
}

void writeTum(const std::string& path, const std::vector<StampedPose3>& trajectory) {
  AtomicFile file(path);
  writeTum(file.stream(), trajectory);
  file.commit();
}

void writeKitti(const std::string& path, const std::vector<StampedPose3>& trajectory) {
  AtomicFile file(path);
  writeKitti(file.stream(), trajectory);
  file.commit();
}

void writeTum(std::ostream& file, const std::vector<StampedPose3>& trajectory) {
  writeLines(file, trajectory, [](std::ostream& out, const StampedPose3& stamped) {
    const Eigen::Vector3d t = stamped.pose.translation();
    const Eigen::Quaterniond q(stamped.pose.linear());
    out << formatStamp(stamped.stamp) << ' ' << t.x() << ' ' << t.y() << ' ' << t.z() << ' ' << q.x() << ' '
        << q.y() << ' ' << q.z() << ' ' << q.w() << '\n';
  });
}

void writeKitti(std::ostream& file, const std::vector<StampedPose3>& trajectory) {
  writeLines(file, trajectory, [](std::ostream& out, const StampedPose3& stamped) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        out << stamped.pose.matrix()(row, column) << (row == 2 && column == 3 ? '\n' : ' ');
      }
    }
  });
}

std::vector<Eigen::Isometry3d> readKittiPoses(const std::string& path) {
  std::vector<Eigen::Isometry3d> poses;
  for (const TextLine& line : readLines(path)) {
    std::istringstream words(line.text);
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int i = 0; i < 12; ++i) words >> pose.matrix()(i / 4, i % 4);
    std::string rest;
    if (!words || words >> rest || !pose.matrix().allFinite()) {
      throw std::runtime_error(path + ":" + std::to_string(line.number) +
                               ": a pose has 12 numbers, the rows of [R|t]");
    }
    poses.push_back(pose);
  }
  return poses;
}

}  // namespace ratslam
