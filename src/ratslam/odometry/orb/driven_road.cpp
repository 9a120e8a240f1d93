#include "ratslam/odometry/orb/driven_road.h"

#include <cmath>
#include <utility>

#include "ratslam/common/angles.h"

namespace ratslam {
namespace {

constexpr double kFarthestBeside = 1.1;  // a patch counts if the camera passes it this near [camera heights]
constexpr double kRemembered = 20.0;  // length of way over which patches and places are kept [camera heights]
constexpr double kSpacing = 0.2;      // least distance between patches, and between places [camera heights]
constexpr auto kMost = static_cast<std::size_t>(kRemembered / kSpacing);
constexpr double kJump = 2.0;            // a longer step is an error and not a motion [camera heights]
constexpr double kLateralTiltDeg = 0.7;  // standard deviation of a road's slope to the side

}  // namespace

std::optional<DrivenHeight> DrivenRoad::heightAbove(const Patch& patch, const Eigen::Vector3d& from,
                                                    const Eigen::Vector3d& to) {
  const Eigen::Vector3d& normal = patch.plane.normal;
  const auto inPlane = [&normal](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(v - normal * normal.dot(v));
  };
  const Eigen::Vector3d step = inPlane(to - from);
  const double square = step.squaredNorm();
  if (!(square > 0.0)) return std::nullopt;
  const Eigen::Vector3d towards = inPlane(patch.centre - from);
  const double share = towards.dot(step) / square;
  if (!(share >= 0.0) || !(share < 1.0)) return std::nullopt;
  DrivenHeight driven;
  driven.height = patch.plane.height - normal.dot(from + share * (to - from));
  const double beside = (towards - share * step).norm() / driven.height;
  if (!(driven.height > 0.0) || beside > kFarthestBeside) return std::nullopt;
  driven.sigma_log = std::hypot(patch.sigma_log, beside * degreesToRadians(kLateralTiltDeg));
  return driven;
}

std::vector<DrivenHeight> DrivenRoad::moveOn(const RigidTransform& T_now_before, double camera_height) {
  const double way = T_now_before.translation.norm();
  if (!(way < kJump * camera_height)) {
    clear();
    return {};
  }
  if (path_.empty()) path_.push_back(Eigen::Vector3d::Zero());
  for (Eigen::Vector3d& place : path_) place = T_now_before * place;
  // Of places close to each other the first and the newest are enough.
  const std::size_t places = path_.size();
  if (places > 1 && (path_[places - 1] - path_[places - 2]).norm() < kSpacing * camera_height)
    path_.pop_back();
  path_.push_back(Eigen::Vector3d::Zero());
  if (path_.size() > kMost) path_.pop_front();
  std::vector<DrivenHeight> heights;
  std::deque<Patch> ahead;
  for (Patch& patch : patches_) {
    patch.plane.normal = (T_now_before.rotation * patch.plane.normal).normalized();
    patch.plane.height += patch.plane.normal.dot(T_now_before.translation);
    patch.centre = T_now_before * patch.centre;
    patch.way += way;
    if (const auto driven = heightAbove(patch, path_[path_.size() - 2], path_.back())) {
      heights.push_back(*driven);
    } else if (patch.plane.height > 0.0 && patch.way < kRemembered * patch.plane.height) {
      ahead.push_back(patch);
    }
  }
  patches_ = std::move(ahead);
  return heights;
}

std::optional<DrivenHeight> DrivenRoad::add(const RoadMeasurement& road) {
  const Patch patch{road.plane, road.centre, road.sigma_centre, 0.0};
  double way = 0.0;
  for (std::size_t i = path_.size(); i-- > 1;) {
    way += (path_[i] - path_[i - 1]).norm();
    if (way > kRemembered * road.plane.height) break;
    if (const auto driven = heightAbove(patch, path_[i - 1], path_[i])) return driven;
  }
  if (patches_.empty() || patches_.back().way >= kSpacing * road.plane.height) patches_.push_back(patch);
  if (patches_.size() > kMost) patches_.pop_front();
  return std::nullopt;
}

void DrivenRoad::rescale(double factor) {
  for (Patch& patch : patches_) {
    patch.plane.height *= factor;
    patch.centre *= factor;
    patch.way *= factor;
  }
  for (Eigen::Vector3d& place : path_) place *= factor;
}

}  // namespace ratslam
