/// A simulated drive through a city of square blocks, for tests and benchmarks of the experience map: true
/// poses, noisy odometry, and the decisions of pose cells that recognise a share of the places passed before
/// in the same direction.
#pragma once

#include <cmath>
#include <cstdint>
#include <map>
#include <random>
#include <tuple>
#include <vector>

#include "ratslam/common/pose2.h"
#include "ratslam/events.h"
#include "ratslam/experience_map/experience_map.h"

namespace ratslam {

struct DriveStep {
  Stamp end = 0;
  OdometryStep motion;
  TopologicalAction action;
  Pose2 truth;
};

struct CityDrive {
  std::uint32_t experiences = 1000;
  int blocks = 6;             ///< streets run along multiples of the block size, 0 to blocks
  int block_size = 40;        ///< [m]; one step is one metre
  double recall_share = 0.2;  ///< of revisited places that are recognised
  double length_noise = 0.0;  ///< relative, per step
  double yaw_noise = 0.0;     ///< [rad] per step
  double scale_walk = 0.0;    ///< of the log-scale, per step
  unsigned seed = 1;
};

/// Steps of 0.1 s; the first has no motion. Runs until `experiences` have been created.
inline std::vector<DriveStep> simulate(const CityDrive& city) {
  std::mt19937 random(city.seed);
  // The distributions of the standard library differ between implementations; these do not.
  const auto uniform = [&] { return (static_cast<double>(random()) + 0.5) / 4294967296.0; };
  const auto normal = [&] {
    const double radius = std::sqrt(-2.0 * std::log(uniform()));
    return radius * std::cos(2.0 * kPi * uniform());
  };

  std::vector<DriveStep> drive(1);
  std::map<std::tuple<int, int, int>, std::uint32_t>
      known;  // place and direction -> experience created there
  int x = 0;
  int y = 0;
  int direction = 0;
  std::uint32_t created = 0;
  std::uint32_t current = 0;
  double log_scale = 0.0;
  const int extent = city.blocks * city.block_size;
  while (created < city.experiences) {
    DriveStep step;
    int turn = 0;
    if (x % city.block_size == 0 && y % city.block_size == 0) {
      const auto leaves = [&](int d) {
        return (d == 0 && x == extent) || (d == 1 && y == extent) || (d == 2 && x == 0) || (d == 3 && y == 0);
      };
      turn = static_cast<int>(random() % 3) - 1;
      while (leaves((direction + turn + 4) % 4)) turn = turn == 1 ? -1 : turn + 1;
      direction = (direction + turn + 4) % 4;
    }
    x += direction == 0 ? 1 : direction == 2 ? -1 : 0;
    y += direction == 1 ? 1 : direction == 3 ? -1 : 0;
    log_scale += city.scale_walk * normal();
    step.end = static_cast<Stamp>(drive.size()) * 100000000;
    step.truth = {static_cast<double>(x), static_cast<double>(y), wrapAngle(direction * kPi / 2.0)};
    step.motion.dt = 0.1;
    step.motion.forward = std::exp(log_scale) * (1.0 + city.length_noise * normal());
    step.motion.rotation = turn * kPi / 2.0 + city.yaw_noise * normal();
    step.action.stamp = step.end;
    step.action.src_id = current;
    const auto place = std::make_tuple(x, y, direction);
    const auto match = known.find(place);
    if (match != known.end() && match->second != current && uniform() < city.recall_share) {
      step.action.kind = ActionKind::kCreateEdge;
      current = match->second;
    } else {
      step.action.kind = ActionKind::kCreateNode;
      known.emplace(place, created);
      current = created++;
    }
    step.action.dest_id = current;
    drive.push_back(step);
  }
  return drive;
}

inline void run(ExperienceMap& map, const std::vector<DriveStep>& drive) {
  map.start(drive.front().end);
  for (std::size_t k = 1; k < drive.size(); ++k) {
    map.integrate(drive[k].end, drive[k].motion);
    map.apply(drive[k].action);
  }
}

/// Laps of a ring with steps of a given length, each turning by a share too little or too much; every place
/// of the later laps is recalled.
inline std::vector<DriveStep> simulateRing(int lap, int steps, double step_length, double turn_error) {
  std::vector<DriveStep> drive(static_cast<std::size_t>(steps) + 1);
  std::uint32_t current = 0;
  for (int k = 1; k <= steps; ++k) {
    DriveStep& step = drive[static_cast<std::size_t>(k)];
    step.end = static_cast<Stamp>(k) * 100000000;
    step.motion.forward = step_length;
    step.motion.rotation = 2.0 * kPi / lap * (1.0 + turn_error);
    step.action.kind = k <= lap ? ActionKind::kCreateNode : ActionKind::kCreateEdge;
    step.action.src_id = current;
    current = static_cast<std::uint32_t>((k - 1) % lap);
    step.action.dest_id = current;
  }
  return drive;
}

}  // namespace ratslam
