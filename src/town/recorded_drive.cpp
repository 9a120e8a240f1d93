#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "ratslam/common/params.h"
#include "town/drive.h"

namespace ratslam {
namespace {

[[noreturn]] void throwBadLine(const std::string& file, std::size_t line, const std::string& problem) {
  throw std::invalid_argument(file + ": line " + std::to_string(line) + ": " + problem);
}

/// All lines of a file as numbers; empty lines at the end are skipped.
std::vector<std::vector<double>> readNumbers(const std::string& file, std::size_t columns) {
  std::ifstream in(file);
  if (!in) throw std::invalid_argument(file + ": cannot be read");
  std::vector<std::vector<double>> rows;
  for (std::string text; std::getline(in, text);) {
    std::istringstream line(text);
    std::vector<double> row;
    for (double value = 0.0; line >> value;) row.push_back(value);
    if (row.empty() && line.eof()) continue;
    if (!line.eof() || row.size() != columns)
      throwBadLine(file, rows.size() + 1, "it must hold " + std::to_string(columns) + " numbers");
    rows.push_back(std::move(row));
  }
  if (rows.empty()) throw std::invalid_argument(file + ": it holds no lines");
  return rows;
}

Eigen::Isometry3d poseFrom(const std::vector<double>& row, const std::string& file, std::size_t line) {
  Eigen::Matrix3d rotation;
  rotation << row[0], row[1], row[2], row[4], row[5], row[6], row[8], row[9], row[10];
  const Eigen::Vector3d place(row[3], row[7], row[11]);
  // Poses are written with few digits, so a rotation is one only roughly: the nearest one is taken.
  if (!place.allFinite() ||
      !((rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm() < 1e-2) ||
      !(rotation.determinant() > 0.0))
    throwBadLine(file, line, "it is not a rigid motion (3x4 matrix, by rows)");
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
  const std::vector<std::vector<double>> rows = readNumbers(poses_file, 12);
  std::vector<double> times;
  if (times_file.empty()) {
    for (std::size_t i = 0; i < rows.size(); ++i) times.push_back(0.1 * static_cast<double>(i));
  } else {
    for (const auto& row : readNumbers(times_file, 1)) {
      if (!std::isfinite(row[0]) || (!times.empty() && !(row[0] > times.back())))
        throwBadLine(times_file, times.size() + 1, "times must increase");
      times.push_back(row[0]);
    }
  }
  std::vector<Eigen::Isometry3d> poses;
  for (const auto& row : rows) poses.push_back(poseFrom(row, poses_file, poses.size() + 1));
  const std::size_t driven =
      frames == 0 ? poses.size() : std::min(poses.size(), static_cast<std::size_t>(frames));
  if (times.size() < driven)
    throw std::invalid_argument(times_file + ": it has " + std::to_string(times.size()) + " times for " +
                                std::to_string(driven) + " poses");

  Drive drive;
  for (std::size_t i = 0; i < driven; ++i)
    drive.poses.push_back({stampFromSeconds(times[i] - times[0]), poses[i]});
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
