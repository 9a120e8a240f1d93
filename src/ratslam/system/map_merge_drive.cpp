#include "ratslam/system/map_merge_drive.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "ratslam/common/angles.h"
#include "ratslam/common/state.h"
#include "ratslam/odometry/uncertainty.h"

namespace ratslam {
namespace {

/// Where the map was lost, its graph has a constraint whose heading is less certain than this (PoseGraphMap: 10 rad). An
/// unmeasured step of the odometry is bounded, with a heading to pi at most (OdometryTimeline).
constexpr double kLostFacing = 3.0 * kPi;  // [rad]

/// Least share of a stretch's length that must be driven forward for errors that grow with the way.
constexpr double kLeastForward = 0.5;

/// Longer steps of a thinned path are divided.
constexpr double kLongestStep = 0.5;  // [s]
constexpr int kMostShares = 1000;

/// Experience of each frame: the one created there, or recalled there.
std::map<std::uint32_t, std::uint32_t> experiencesOf(const ExperienceMap& map,
                                                     const std::vector<Constraint>& constraints) {
  std::map<std::uint32_t, std::uint32_t> created;
  for (std::uint32_t id = 0; id < map.graph().experiences().size(); ++id) created[map.frameOf(id)] = id;
  std::map<std::uint32_t, std::uint32_t> all = created;
  for (const Constraint& recall : constraints) {
    // Merged maps have no image geometry: so every recall is vague, and no constraint of a pass (known_ground.cpp) is.
    if (!recall.recall || !recall.vague) continue;
    if (const auto there = created.find(recall.from); there != created.end())
      all.try_emplace(recall.to, there->second);
  }
  return all;
}

bool usable(const TwistCovariance& covariance) { return whyAbsurd(covariance).empty(); }

}  // namespace

TwistCovariance KnownErrors::ofTwist(double forward, double seconds) const {
  const Eigen::Matrix4d spread =
      growWithTime() ? Eigen::Matrix4d(variance_per_second / seconds)
                     : Eigen::Matrix4d(variance_per_metre * (std::abs(forward) / (seconds * seconds)));
  TwistCovariance covariance = TwistCovariance::Zero();
  covariance.diagonal() << spread(0, 0), spread(1, 1), spread(2, 2), 0.0, 0.0, spread(3, 3);
  return covariance;
}

DrivenStep drivenBetween(const StampedPose& from, const StampedPose& to) {
  return {
      (to.pose.x - from.pose.x) * std::cos(to.pose.yaw) + (to.pose.y - from.pose.y) * std::sin(to.pose.yaw),
      wrapAngle(to.pose.yaw - from.pose.yaw)};
}

int sharesOf(double seconds) {
  return static_cast<int>(std::clamp(std::ceil(seconds / kLongestStep), 1.0, double{kMostShares}));
}

std::vector<std::uint32_t> componentsOf(const ExperienceGraph& graph) {
  std::vector<std::uint32_t> parent(graph.experiences().size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root = [&parent](std::uint32_t id) {
    while (parent[id] != id) id = parent[id] = parent[parent[id]];
    return id;
  };
  for (const Link& link : graph.links()) {
    const std::uint32_t from = root(link.from);
    const std::uint32_t to = root(link.to);
    parent[std::max(from, to)] = std::min(from, to);
  }
  std::vector<std::uint32_t> component(parent.size());
  for (std::uint32_t id = 0; id < parent.size(); ++id) component[id] = root(id);
  return component;
}

KeptDrive::KeptDrive(const ExperienceMap& map, const State& saved, std::vector<Stamp> breaks, double reach)
    : path_(map.finalTrajectory()), errors_(path_.size()), lost_(path_.size()), breaks_(std::move(breaks)) {
  Trajectory trajectory;
  saved.get("trajectory", trajectory);
  Constraints constraints;
  if (saved.child("solver").hasChild("graph"))
    constraints = saved.child("solver").child("graph").get<Constraints>("constraints");
  findViews(map, trajectory, constraints, reach);
  readErrors(trajectory, constraints);
  for (std::optional<KnownErrors>& errors : errors_) {
    if (errors) errors->unit.constant_sigma = map.unitSigma();
  }
}

bool KeptDrive::goesOn(std::size_t next) const {
  const Stamp before = path_[next - 1].stamp;
  const Stamp now = path_[next].stamp;
  const bool broken =
      std::any_of(breaks_.begin(), breaks_.end(), [&](Stamp end) { return before <= end && now > end; });
  return now > before && !broken && !lost_[next] && component_[next] == component_[next - 1];
}

void KeptDrive::findViews(const ExperienceMap& map, const Trajectory& trajectory,
                          const Constraints& constraints, double reach) {
  const std::map<std::uint32_t, std::uint32_t> experience_of = experiencesOf(map, constraints);
  const std::vector<std::uint32_t> components = componentsOf(map.graph());
  std::uint32_t latest = 0;
  for (std::size_t k = 0; k < path_.size(); ++k) {
    const Trajectory::Sample& sample = trajectory.samples()[k];
    const auto there = experience_of.find(sample.frame);
    if (there != experience_of.end()) latest = there->second;
    component_.push_back(components[latest]);
    const double away = path_[k].pose.scale() * std::hypot(sample.relative.x, sample.relative.y);
    const bool known = there != experience_of.end() && away <= reach;
    seen_.push_back(known ? std::make_optional(there->second) : std::nullopt);
  }
}

/// The graph has a constraint for the motion from each frame to the next.
void KeptDrive::readErrors(const Trajectory& trajectory, const Constraints& constraints) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, Constraint> ways;
  for (const Constraint& way : constraints) {
    if (!way.closes()) ways[{way.from, way.to}] = way;
  }
  const auto& samples = trajectory.samples();
  for (std::size_t k = 1, first = 1; k < samples.size(); ++k) {
    if (samples[k].frame == samples[k - 1].frame) continue;
    const auto way = ways.find({samples[k - 1].frame, samples[k].frame});
    if (way != ways.end()) {
      lost_[k] = way->second.yaw_weight * kLostFacing < 1.0;
      const std::optional<KnownErrors> errors = lost_[k] ? std::nullopt : errorsOf(way->second, first, k);
      std::fill(errors_.begin() + static_cast<std::ptrdiff_t>(first),
                errors_.begin() + static_cast<std::ptrdiff_t>(k + 1), errors);
    }
    first = k + 1;
  }
}

/// Errors of the steps from pose `first` - 1 to pose `last`.
std::optional<KnownErrors> KeptDrive::errorsOf(const Constraint& way, std::size_t first,
                                               std::size_t last) const {
  double length = 0.0;
  double forward = 0.0;
  for (std::size_t k = first; k <= last; ++k) {
    length += std::hypot(path_[k].pose.x - path_[k - 1].pose.x, path_[k].pose.y - path_[k - 1].pose.y);
    forward += std::abs(drivenBetween(path_[k - 1], path_[k]).forward);
  }
  KnownErrors errors;
  const Eigen::Matrix4d variance = covarianceOf(way);
  if (length > 0.0) {
    errors.variance_per_metre = variance / length;
    const double scale_variance = 1.0 / (way.scale_weight * way.scale_weight);
    const double lost = 1.0 - way.scale_kept * way.scale_kept;
    double walk = scale_variance;
    if (way.scale_kept > 0.0 && lost > 0.0) {  // inverts the sum of MotionError for an anchored unit
      errors.unit.anchor_sigma = std::sqrt(scale_variance / lost);
      walk = -2.0 * std::log(way.scale_kept) * scale_variance / lost;
    }
    errors.unit.walk_sigma = std::sqrt(walk / length);
  }
  // A silence followed by a few centimetres would put all its errors on these, as more than an odometry can have.
  bool with_way = length > 0.0 && forward >= kLeastForward * length;
  for (std::size_t k = first; with_way && k <= last; ++k) {
    const double seconds = secondsBetween(path_[k - 1].stamp, path_[k].stamp);
    const double shares = sharesOf(seconds);
    const double step = drivenBetween(path_[k - 1], path_[k]).forward;
    with_way = seconds <= 0.0 || usable(errors.ofTwist(step / shares, seconds / shares));
  }
  if (with_way) return errors;
  const double seconds = secondsBetween(path_[first - 1].stamp, path_[last].stamp);
  if (seconds <= 0.0) return std::nullopt;
  errors.variance_per_metre.setZero();
  errors.variance_per_second = variance / seconds;
  return errors;
}

}  // namespace ratslam
