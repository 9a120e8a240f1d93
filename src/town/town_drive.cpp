#include <algorithm>
#include <array>
#include <cmath>

#include "ratslam/common/angles.h"
#include "ratslam/common/params.h"
#include "town/drive.h"

namespace ratslam {
namespace {

constexpr double kBlock = 38.0;                  // from street to street [m]
constexpr double kRightOfCentre = 1.6;           // [m]
constexpr double kStart = 9.0;                   // of the drive, past the first corner [m]
constexpr double kStep = 0.25;                   // between points of the path [m]
constexpr double kSlow = 5.0, kFast = 11.5;      // [m/s]
constexpr double kSideways = 3.4, kAlong = 2.4;  // accelerations [m/s^2]

struct Corner {
  int column, row;
};

/// The circuit, corner by corner. Street names as comments: a capital letter is a street driven for the first
/// time.
constexpr std::array<Corner, 14> kCircuit{{
    {0, 0},  // A north
    {0, 1},  // B east
    {1, 1},  // C south
    {1, 0},  // D west
    {0, 0},  // a again, first revisit
    {0, 1},  // E north
    {0, 2},  // F east
    {1, 2},  // G south
    {1, 1},  // b against its first direction
    {0, 1},  // e again, second revisit; f, g with it
    {0, 2},  // f
    {1, 2},  // g
    {1, 1},  // c again, third revisit: last time g led elsewhere
    {1, 0},  // d again, and back to the start
}};

using Point = Eigen::Vector2d;  // x, z

/// Where the lane turns at a corner, and how.
struct LaneCorner {
  Point in, out, place;  ///< directions before and after; the lanes' crossing
  double radius;         ///< 0: straight on
};

LaneCorner laneCorner(std::size_t i) {
  const auto node = [](std::size_t k) {
    const Corner& corner = kCircuit[k % kCircuit.size()];
    return Point(kBlock * corner.column, kBlock * corner.row);
  };
  const Point here = node(i);
  LaneCorner corner;
  corner.in = (here - node(i + kCircuit.size() - 1)).normalized();
  corner.out = (node(i + 1) - here).normalized();
  const auto right_of = [](const Point& d) { return Point(d.y(), -d.x()); };
  const double turn = corner.in.x() * corner.out.y() - corner.in.y() * corner.out.x();  // +1 left, -1 right
  corner.radius = turn == 0.0 ? 0.0 : (turn > 0.0 ? 9.0 : 6.5);
  corner.place = here + kRightOfCentre * (turn == 0.0 ? right_of(corner.in)
                                                      : Point(right_of(corner.in) + right_of(corner.out)));
  return corner;
}

/// The lane from past the first corner on, over a number of rounds, as points kStep apart.
std::vector<Point> lanePoints(int rounds) {
  std::vector<Point> rough;
  const LaneCorner start = laneCorner(0);
  rough.emplace_back(start.place + kStart * start.out);
  for (std::size_t i = 1; i <= kCircuit.size() * static_cast<std::size_t>(rounds); ++i) {
    const LaneCorner corner = laneCorner(i % kCircuit.size());
    if (corner.radius == 0.0) continue;
    const Point centre = corner.place - corner.radius * corner.in + corner.radius * corner.out;
    constexpr int kArc = 24;
    for (int k = 0; k <= kArc; ++k) {
      const double angle = 0.5 * kPi * k / kArc;
      rough.emplace_back(centre +
                         corner.radius * (std::sin(angle) * corner.in - std::cos(angle) * corner.out));
    }
  }
  rough.emplace_back(start.place + kStart * start.out);
  std::vector<Point> points;
  double to_next = 0.0;
  for (std::size_t i = 0; i + 1 < rough.size(); ++i) {
    const double length = (rough[i + 1] - rough[i]).norm();
    for (; to_next < length; to_next += kStep)
      points.emplace_back(rough[i] + to_next / length * (rough[i + 1] - rough[i]));
    to_next -= length;
  }
  return points;
}

/// Means over +-`reach` points, so that steering sets in and ends gradually.
std::vector<Point> smoothed(const std::vector<Point>& points, int reach) {
  const int count = static_cast<int>(points.size());
  std::vector<Point> result;
  for (int i = 0; i < count; ++i) {
    const int r = std::min({reach, i, count - 1 - i});
    Point sum = Point::Zero();
    for (int k = i - r; k <= i + r; ++k) sum += points[static_cast<std::size_t>(k)];
    result.emplace_back(sum / (2 * r + 1));
  }
  return result;
}

struct LaneState {
  Point place;
  double bearing;  ///< from z towards x, not wrapped [rad]
  double speed;    ///< [m/s]
};

std::vector<LaneState> laneStates(const std::vector<Point>& points) {
  std::vector<LaneState> states;
  double bearing = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Point ahead = points[std::min(i + 1, points.size() - 1)] - points[i == 0 ? 0 : i - 1];
    bearing += wrapAngle(std::atan2(ahead.x(), ahead.y()) - bearing);
    states.push_back({points[i], bearing, kFast});
  }
  constexpr std::size_t kReach = 4;  // curvature over 2 m
  for (std::size_t i = kReach; i + kReach < states.size(); ++i) {
    const double curvature =
        std::abs(states[i + kReach].bearing - states[i - kReach].bearing) / (2 * kReach * kStep);
    states[i].speed = std::clamp(std::sqrt(kSideways / std::max(curvature, 1e-6)), kSlow, kFast);
  }
  const auto limit = [&](LaneState& next, const LaneState& from) {
    next.speed = std::min(next.speed, std::sqrt(from.speed * from.speed + 2.0 * kAlong * kStep));
  };
  for (std::size_t i = 1; i < states.size(); ++i) limit(states[i], states[i - 1]);
  for (std::size_t i = states.size() - 1; i > 0; --i) limit(states[i - 1], states[i]);
  return states;
}

}  // namespace

Drive planTownDrive(int frames) {
  if (frames < 1) throwBadValue("frames", frames, "a drive needs at least one frame");
  constexpr double kPeriod = 0.1;  // [s]
  Drive drive;
  const auto lane = [](int rounds) { return smoothed(smoothed(lanePoints(rounds), 6), 6); };
  const double round = kStep * static_cast<double>(lanePoints(1).size());
  const int rounds = 1 + static_cast<int>(frames * kPeriod * kFast / round + 0.1);
  const std::vector<LaneState> states = laneStates(lane(rounds));
  const Point origin = states.front().place;
  double along = 0.0;
  for (int frame = 0; frame < frames; ++frame) {
    const double cell = std::min(along / kStep, static_cast<double>(states.size()) - 1.001);
    const auto i = static_cast<std::size_t>(cell);
    const double t = cell - static_cast<double>(i);
    const Point place = states[i].place + t * (states[i + 1].place - states[i].place) - origin;
    const double bearing = states[i].bearing + t * (states[i + 1].bearing - states[i].bearing);
    DrivePose pose;
    pose.stamp = stampFromSeconds(frame * kPeriod);
    pose.T_world_camera.translation() = Eigen::Vector3d(place.x(), 0.0, place.y());
    pose.T_world_camera.linear() = Eigen::AngleAxisd(bearing, Eigen::Vector3d::UnitY()).toRotationMatrix();
    drive.poses.push_back(pose);
    along += kPeriod * (states[i].speed + t * (states[i + 1].speed - states[i].speed));
  }
  std::vector<RoadPoint> circuit;
  for (const Point& point : lane(1))
    circuit.push_back({point.x() - origin.x(), point.y() - origin.y(), -kCameraHeight});
  drive.roads.push_back(std::move(circuit));
  constexpr double kBeyond = 110.0;  // streets lead out of the blocks this far [m]
  const auto add = [&](double x0, double z0, double x1, double z1) {
    drive.roads.push_back({{x0 - origin.x(), z0 - origin.y(), -kCameraHeight},
                           {x1 - origin.x(), z1 - origin.y(), -kCameraHeight}});
  };
  for (int column = 0; column <= 1; ++column) {
    const double x = kBlock * column + kRightOfCentre;
    add(x, -kBeyond, x, 2.0 * kBlock + kBeyond);
  }
  for (int row = 0; row <= 2; ++row) {
    const double z = kBlock * row - kRightOfCentre;
    add(-kBeyond, z, kBlock + kBeyond, z);
  }
  return drive;
}

}  // namespace ratslam
