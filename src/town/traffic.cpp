#include "town/traffic.h"

#include <algorithm>
#include <cmath>

#include "town/hash.h"
#include "town/town_parts.h"

namespace ratslam {
namespace {

constexpr double kSight = 150.0;    // [m] of way at which cars come into being, small and in the haze
constexpr double kOtherLane = 2.9;  // [m] to the left
constexpr double kHeadway = 15.0;   // smallest distance of a car in front [m]
constexpr double kApproach = 0.12;  // how fast it comes and goes [m/s^2]
constexpr double kSafe = 2.7;       // no car's middle comes nearer to the camera [m]

}  // namespace

Traffic::Traffic(const Drive& drive, const RoadField& roads, const TextureLibrary& textures, int cars,
                 std::uint64_t seed)
    : drive_(drive), roads_(roads), textures_(textures), way_{0.0} {
  for (std::size_t i = 1; i < drive.poses.size(); ++i) {
    const Eigen::Vector3d step =
        drive.poses[i].T_world_camera.translation() - drive.poses[i - 1].T_world_camera.translation();
    way_.push_back(way_.back() + std::hypot(step.x(), step.z()));
  }
  HashStream random(hashOf(seed, 90));
  for (int i = 0; i < cars; ++i) {
    const double share = (i + random.range(0.2, 0.8)) / cars;
    const auto frame =
        std::min(static_cast<std::size_t>(share * static_cast<double>(way_.size())), way_.size() - 1);
    cars_.push_back({i % 4 == 3, toSeconds(drive.poses[frame].stamp), way_[frame], random.range(6.0, 12.0),
                     random.next()});
  }
}

std::vector<MeshTriangle> Traffic::at(std::size_t frame) const {
  Mesh mesh;
  const double time = toSeconds(drive_.poses[frame].stamp);
  const Eigen::Vector3d camera = drive_.poses[frame].T_world_camera.translation();
  for (const Car& car : cars_) {
    const double elapsed = time - car.time;
    const double way =
        car.in_front ? way_[frame] + kHeadway + kApproach * elapsed * elapsed : car.way - car.speed * elapsed;
    if (std::abs(way - way_[frame]) > kSight || way < way_.front() || way >= way_.back()) continue;
    const auto next =
        static_cast<std::size_t>(std::upper_bound(way_.begin(), way_.end(), way) - way_.begin());
    const Eigen::Isometry3d& a = drive_.poses[next - 1].T_world_camera;
    const Eigen::Isometry3d& b = drive_.poses[next].T_world_camera;
    const double t = (way - way_[next - 1]) / (way_[next] - way_[next - 1]);
    const Eigen::Vector3d place = a.translation() + t * (b.translation() - a.translation());
    const Eigen::Vector3d forward = a.linear().col(2) + t * (b.linear().col(2) - a.linear().col(2));
    const double length = std::hypot(forward.x(), forward.z());
    const double ahead_x = forward.x() / length;
    const double ahead_z = forward.z() / length;
    const double left = car.in_front ? 0.0 : kOtherLane;
    const double x = place.x() - left * ahead_z;
    const double z = place.z() + left * ahead_x;
    if (std::hypot(x - camera.x(), z - camera.z()) < kSafe) continue;
    const double sign = car.in_front ? 1.0 : -1.0;
    addCar(mesh, textures_, UprightFrame(x, z, roads_.height(x, z), sign * ahead_x, sign * ahead_z),
           car.kind);
  }
  return mesh.triangles();
}

}  // namespace ratslam
