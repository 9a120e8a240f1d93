#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "ratslam/common/params.h"
#include "ratslam/common/text_file.h"
#include "town/drive.h"

namespace ratslam {
namespace {

[[noreturn]] void throwBadLine(const std::string& file, int line, const std::string& problem) {
  throw std::invalid_argument(file + ": line " + std::to_string(line) + ": " + problem);
}

struct Row {
  int line = 0;
  std::vector<double> numbers;
};

/// The lines of a file as numbers, without blank lines.
std::vector<Row> readRows(const std::string& file, std::size_t columns) {
  std::vector<Row> rows;
  for (const TextLine& line : readLines(file)) {
    std::istringstream words(line.text);
    Row row{line.number, {}};
    for (double value = 0.0; words >> value;) row.numbers.push_back(value);
    if (!words.eof() || row.numbers.size() != columns)
      throwBadLine(file, line.number, "it must hold " + std::to_string(columns) + " numbers");
    rows.push_back(std::move(row));
  }
  if (rows.empty()) throw std::invalid_argument(file + ": it holds no lines");
  return rows;
}

/// Times of poses from the first one on. Their stamps increase, not only their digits.
std::vector<Stamp> readTimes(const std::string& file) {
  constexpr double kLatest = 4e9;        // [s], as Unix time the year 2096
  constexpr Stamp kLongest = 1000000;    // [s], twelve days
  constexpr Stamp kSecond = 1000000000;  // [ns]
  std::vector<Stamp> stamps;
  double first = 0.0;
  for (const Row& row : readRows(file, 1)) {
    const double time = row.numbers[0];
    if (!(time >= 0.0 && time <= kLatest)) throwBadLine(file, row.line, "a time must lie within [0, 4e9] s");
    if (stamps.empty()) first = time;
    const Stamp stamp = stampFromSeconds(time - first);
    if (!stamps.empty() && stamp <= stamps.back()) throwBadLine(file, row.line, "times must increase");
    if (stamp > kLongest * kSecond) throwBadLine(file, row.line, "a drive must end within 1e6 s");
    stamps.push_back(stamp);
  }
  return stamps;
}

Eigen::Isometry3d poseFrom(const Row& numbered, const std::string& file) {
  const std::vector<double>& row = numbered.numbers;
  Eigen::Matrix3d rotation;
  rotation << row[0], row[1], row[2], row[4], row[5], row[6], row[8], row[9], row[10];
  const Eigen::Vector3d place(row[3], row[7], row[11]);
  // Poses are written with few digits, so a rotation is one only roughly: the nearest one is taken.
  if (!place.allFinite() ||
      !((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm() < 1e-2) ||
      !(rotation.determinant() > 0.0))
    throwBadLine(file, numbered.line, "it is not a rigid motion (3x4 matrix, by rows)");
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
  pose.translation() = place;
  return pose;
}

/// Means of values over +-`reach` metres of way.
std::vector<double> smoothAlong(const std::vector<double>& way, const std::vector<double>& values,
                                double reach) {
  std::vector<double> result;
  for (std::size_t i = 0; i < values.size(); ++i) {
    // The window shrinks towards both ends, so that it stays centred and a slope is kept.
    const double r = std::min({reach, way[i] - way.front(), way.back() - way[i]});
    double sum = values[i];
    int count = 1;
    for (std::size_t k = i; k-- > 0 && way[i] - way[k] <= r; ++count) sum += values[k];
    for (std::size_t k = i + 1; k < values.size() && way[k] - way[i] <= r; ++count, ++k) sum += values[k];
    result.push_back(sum / count);
  }
  return result;
}

/// Way driven up to each pose, over the ground [m].
std::vector<double> wayAlong(const std::vector<Eigen::Isometry3d>& poses) {
  std::vector<double> way{0.0};
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const Eigen::Vector3d step = poses[i].translation() - poses[i - 1].translation();
    way.push_back(way.back() + std::hypot(step.x(), step.z()));
  }
  return way;
}

constexpr double kSmoothing = 6.0;  // [m]

}  // namespace

Drive loadDrive(const std::string& poses_file, const std::string& times_file, int frames) {
  if (frames < 0) throwBadValue("frames", frames, "it must not be negative");
  std::vector<Eigen::Isometry3d> poses;
  for (const Row& row : readRows(poses_file, 12)) poses.push_back(poseFrom(row, poses_file));
  std::vector<Stamp> stamps;
  if (times_file.empty()) {
    for (std::size_t i = 0; i < poses.size(); ++i)
      stamps.push_back(stampFromSeconds(0.1 * static_cast<double>(i)));
  } else {
    stamps = readTimes(times_file);
  }
  const std::size_t driven =
      frames == 0 ? poses.size() : std::min(poses.size(), static_cast<std::size_t>(frames));
  if (stamps.size() < driven)
    throw std::invalid_argument(times_file + ": it has " + std::to_string(stamps.size()) + " times for " +
                                std::to_string(driven) + " poses");

  Drive drive;
  for (std::size_t i = 0; i < driven; ++i) drive.poses.push_back({stamps[i], poses[i]});
  std::vector<double> heights;
  for (const auto& pose : poses) heights.push_back(-pose.translation().y() - kCameraHeight);
  heights = smoothAlong(wayAlong(poses), heights, kSmoothing);
  const auto point = [&](std::size_t i, double ahead) {
    const Eigen::Vector3d forward = poses[i].linear().col(2);
    const Eigen::Vector3d place =
        poses[i].translation() + ahead * Eigen::Vector3d(forward.x(), 0.0, forward.z());
    return RoadPoint{place.x(), place.z(), heights[i]};
  };
  constexpr double kBeyond = 40.0;  // the road starts before the first pose and ends after the last [m]
  std::vector<RoadPoint> road{point(0, -kBeyond)};
  for (std::size_t i = 0; i < poses.size(); ++i) road.push_back(point(i, 0.0));
  road.push_back(point(poses.size() - 1, kBeyond));
  drive.roads.push_back(std::move(road));
  return drive;
}

void settleOnRoad(Drive& drive, const RoadField& roads) {
  std::vector<Eigen::Isometry3d> poses;
  std::vector<double> heights;
  std::vector<double> ground;
  for (const DrivePose& pose : drive.poses) {
    poses.push_back(pose.T_world_camera);
    const Eigen::Vector3d& place = pose.T_world_camera.translation();
    heights.push_back(-place.y());
    ground.push_back(roads.height(place.x(), place.z()));
  }
  const std::vector<double> way = wayAlong(poses);
  const std::vector<double> slow = smoothAlong(way, heights, kSmoothing);
  // A car's body does not feel the road's edges, but its mean below the wheels [m].
  constexpr double kAxles = 1.4;
  const std::vector<double> felt = smoothAlong(way, ground, kAxles);
  for (std::size_t i = 0; i < poses.size(); ++i)
    drive.poses[i].T_world_camera.translation().y() = -(felt[i] + kCameraHeight + heights[i] - slow[i]);
}

}  // namespace ratslam
