#include "ratslam/experience_map/experience_map.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

#include "ratslam/experience_map/solver/pose_graph_map.h"
#include "ratslam/experience_map/solver/relaxation.h"
#include "ratslam/odometry/uncertainty.h"

namespace ratslam {
namespace {

constexpr double kUnknownUnit = 1.0;  // an error as large as the unit itself: beyond it nothing more is said

std::unique_ptr<MapSolver> makeSolver(const ExperienceMapParams& params) {
  if (params.relaxes()) return std::make_unique<Relaxation>(params.exp_loops, params.exp_correction);
  return std::make_unique<PoseGraphMap>(params);
}

const ExperienceMapParams& validated(const ExperienceMapParams& params) {
  params.validate();
  return params;
}

bool finite(const RecallGeometry& g) {
  return std::isfinite(g.relative_rad) && std::isfinite(g.direction_rad) && std::isfinite(g.distance) &&
         std::isfinite(g.sigma_rotation) && g.sigma_rotation > 0.0 && std::isfinite(g.sigma_direction) &&
         g.sigma_direction > 0.0 && std::isfinite(g.ahead) && std::isfinite(g.sigma_distance) &&
         g.sigma_distance >= 0.0;
}

/// Whether a predicted step has a frame of its own: the first ones of a stretch, so that a correction can bend it. A
/// camera may stay dark all night, so that later only every power of two has.
bool needsFrame(std::uint64_t bridged_steps) {
  constexpr std::uint64_t kEach = 256;
  return bridged_steps <= kEach || (bridged_steps & (bridged_steps - 1)) == 0;
}

/// Whether the robot stands: it is slower than 1 cm/s and 0.5 deg/s.
bool stands(const OdometryStep& step, double seconds) {
  return std::hypot(step.forward, step.left, step.up) <= 0.01 * seconds &&
         std::abs(step.rotation) <= degreesToRadians(0.5) * seconds;
}

/// Whether a sample after `first` has a frame that is older than that sample. Then the robot was placed on known
/// ground since: its place no longer depends on the motion before.
bool comesToOldFrame(const std::vector<Trajectory::Sample>& samples, std::size_t first) {
  std::uint32_t newest = 0;
  for (std::size_t k = 0; k <= first; ++k) newest = std::max(newest, samples[k].frame);
  for (std::size_t k = first + 1; k < samples.size(); ++k) {
    if (samples[k].frame != samples[k - 1].frame && samples[k].frame <= newest) return true;
  }
  return false;
}

/// A motion of base_link in level axes. @param tilt  of base_link where the motion begins
RelativePose levelled(const Eigen::Isometry3d& motion, const Eigen::Quaterniond& tilt, bool with_height) {
  const Eigen::Isometry3d level = Eigen::Isometry3d(tilt) * motion;
  const Eigen::Vector3d& moved = level.translation();
  return {moved.x(), moved.y(), with_height ? moved.z() : 0.0, yawOf(level)};
}

/// The corrected poses of the samples from the beginning of a corrected stretch on, in the robot's axes there.
/// Where the correction states a pose, it holds. Between two such samples the old path is kept and its error is
/// interpolated. The path after the stretch is carried along with its end.
class CourseOfWay {
 public:
  template <class PoseOf>
  CourseOfWay(const OdometryCorrection& correction, const Eigen::Quaterniond& tilt, bool with_height,
              const Trajectory& trajectory, std::size_t first, std::size_t last, PoseOf&& pose_of)
      : first_(first) {
    const auto& samples = trajectory.samples();
    std::map<Stamp, RelativePose> said;
    for (const StampedMotion& moved : correction.way)
      said[moved.stamp] = levelled(moved.motion, tilt, with_height);
    const RelativePose end = levelled(correction.motion, tilt, with_height);
    const MapPose begin = pose_of(samples[first]);
    const RelativePose thought_end = between(begin, pose_of(samples[last]));
    std::vector<Error> errors{{correction.from, {}}};
    for (std::size_t k = first + 1; k < last; ++k) {
      const auto known = said.find(samples[k].stamp);
      if (known == said.end()) continue;
      errors.push_back({known->first, minus(known->second, between(begin, pose_of(samples[k])))});
    }
    errors.push_back({correction.to, minus(end, thought_end)});
    std::size_t next = 1;
    for (std::size_t k = first; k < samples.size(); ++k) {
      const auto known = said.find(samples[k].stamp);
      RelativePose pose = between(begin, pose_of(samples[k]));
      if (k > last) {  // after the stretch: the old motion, from its corrected end
        const MapPose carried = compose(asPose(end), between(asPose(thought_end), asPose(pose)));
        poses_.push_back({carried.x, carried.y, carried.z, carried.yaw});
        continue;
      }
      while (next + 1 < errors.size() && errors[next].stamp < samples[k].stamp) ++next;
      const RelativePose error = blend(errors[next - 1], errors[next], samples[k].stamp);
      pose.x += error.x;
      pose.y += error.y;
      pose.z += error.z;
      pose.yaw = wrapAngle(pose.yaw + error.yaw);
      poses_.push_back(k == last ? end : known != said.end() ? known->second : pose);
    }
  }

  const RelativePose& at(std::size_t sample) const { return poses_[sample - first_]; }

 private:
  /// Error of the old path at a stamp.
  struct Error {
    Stamp stamp = 0;
    RelativePose of;
  };
  static RelativePose minus(const RelativePose& a, const RelativePose& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z, wrapAngle(a.yaw - b.yaw)};
  }
  static RelativePose blend(const Error& a, const Error& b, Stamp stamp) {
    const double share = secondsBetween(a.stamp, stamp) / secondsBetween(a.stamp, b.stamp);
    const RelativePose whole = minus(b.of, a.of);
    return {a.of.x + share * whole.x, a.of.y + share * whole.y, a.of.z + share * whole.z,
            a.of.yaw + share * whole.yaw};
  }
  static MapPose asPose(const RelativePose& pose) { return {pose.x, pose.y, pose.z, pose.yaw, 0.0}; }

  std::size_t first_;
  std::vector<RelativePose> poses_;
};

}  // namespace

ExperienceMap::ExperienceMap(const ExperienceMapParams& params)
    : params_(validated(params)),
      solver_(makeSolver(params_)),
      trajectory_(static_cast<std::size_t>(params_.exp_trajectory_poses)),
      planner_(params_.exp_goal_radius, params_.exp_goal_timeout) {
  origin_.yaw = wrapAngle(degreesToRadians(params_.exp_initial_em_deg));
}

void ExperienceMap::start(Stamp stamp) {
  stayFrom(stamp);  // no link crosses the jump, so the time before it is not needed
  robot_.lost = current_.has_value();
  clock_ = stamp;
  record();
}

OdometryStep ExperienceMap::inRobotsUnit(const OdometryStep& step) const {
  OdometryStep carried = step;
  if (robot_.standing.log_unit != 0.0) {
    const double unit = std::exp(robot_.standing.log_unit);
    carried.forward *= unit;
    carried.left *= unit;
    carried.up *= unit;
    if (carried.covariance) {
      const Eigen::Vector4d units(unit, unit, unit, 1.0);
      carried.covariance = units.asDiagonal() * *carried.covariance * units.asDiagonal();
    }
  }
  if (!params_.exp_height) carried.up = 0.0;
  return carried;
}

void ExperienceMap::integrate(Stamp end, const OdometryStep& step) {
  if (!clock_) throw std::invalid_argument("odometry: the clock of the experience map has not been started");
  if (end < *clock_) {
    throw std::invalid_argument("odometry: stamp " + std::to_string(end) + " ns lies before " +
                                std::to_string(*clock_) + " ns");
  }
  if (!std::isfinite(step.rotation) || !std::isfinite(step.forward) || !std::isfinite(step.left) ||
      !std::isfinite(step.up)) {
    throw std::invalid_argument("odometry: motion up to stamp " + std::to_string(end) + " ns is not finite");
  }
  if (step.unit) unit_sigma_ = std::max(unit_sigma_, std::min(step.unit->constant_sigma, kUnknownUnit));
  const OdometryStep carried = inRobotsUnit(step);
  // A predicted stretch gets a link of its own, so that it can be corrected apart from the measured ones.
  bridged_steps_ = step.bridged ? bridged_steps_ + 1 : 0;
  if (learning_ && step.bridged && needsFrame(bridged_steps_)) {
    robot_ = solver_->anchor(graph_, robot_);
    record();
  }
  robot_.motion.add(carried);
  tilt_ = step.tilt;
  if (stands(step, secondsBetween(*clock_, end))) stood_ns_ += end - *clock_;
  clock_ = end;
  solver_->resume(graph_);
  if (current_) planner_.update(graph_, *current_, *clock_);
  record();
}

void ExperienceMap::correct(const OdometryCorrection& correction) {
  if (!correction.motion.matrix().allFinite() || !correction.covariance.allFinite()) {
    throw std::invalid_argument("correction of the odometry up to stamp " + std::to_string(correction.to) +
                                " ns is not finite");
  }
  const std::optional<std::size_t> first = trajectory_.indexAt(correction.from);
  const std::optional<std::size_t> last = trajectory_.indexAt(correction.to);
  if (!solver_->corrects() || robot_.lost || !first || !last || *last <= *first ||
      trajectory_.samples()[*first].stamp != correction.from ||
      comesToOldFrame(trajectory_.samples(), *first)) {
    return;
  }
  const Trajectory::Sample before = trajectory_.samples()[*first];
  const CourseOfWay course(
      correction, before.tilt, params_.exp_height, trajectory_, *first, *last,
      [this](const Trajectory::Sample& s) { return compose(framePose(s.frame), s.relative); });
  CorrectedWay way;
  way.from = before.frame;
  way.before = before.relative;
  for (const auto& bent : trajectory_.bend(*first, [&course](std::size_t k) { return course.at(k); })) {
    way.frames.emplace_back(bent.frame, bent.pose);
    if (bent.sample <= *last) ++way.within;
  }
  way.covariance = stepCovariance(correction.covariance, before.tilt, 1.0);
  robot_.motion.pose = trajectory_.samples().back().relative;
  solver_->correct(graph_, way);
  solver_->update(graph_, robot_);
  record();
}

void ExperienceMap::apply(const TopologicalAction& action, const RecallGeometry* geometry) {
  checkAction(action, geometry);
  if (!learning_) return locate(action, geometry);
  switch (action.kind) {
    case ActionKind::kNone:
      return;
    case ActionKind::kCreateNode:
      create(geometry);
      break;
    case ActionKind::kCreateEdge:
    case ActionKind::kSetNode:
      recall(action, geometry);
      break;
  }
  if (!ignored_) stayFrom(*clock_);
  solver_->update(graph_, robot_);
  planner_.update(graph_, *current_, *clock_);
  record();
}

void ExperienceMap::settle() { solver_->settle(graph_); }

MapPose ExperienceMap::robotPose() const { return compose(framePose(robot_.frame), robot_.motion.pose); }

std::optional<Eigen::Matrix4d> ExperienceMap::robotCovariance() const {
  std::optional<Eigen::Matrix4d> covariance = current_ ? solver_->covariance(robot_) : std::nullopt;
  if (covariance) {
    // No loop shows an error of the metre, since it stretches the whole map. So the solver leaves it out.
    const MapPose here = robotPose();
    const MapPose& first = graph_.pose(0);
    const Eigen::Vector4d stretched(here.x - first.x, here.y - first.y, here.z - first.z, 0.0);
    *covariance += unit_sigma_ * unit_sigma_ * stretched * stretched.transpose();
  }
  return covariance;
}

std::vector<StampedPose> ExperienceMap::finalTrajectory() const {
  return trajectory_.path([this](std::uint32_t frame) { return framePose(frame); });
}

const Goal& ExperienceMap::setGoal(double x, double y) {
  if (!current_) return planner_.refuse("the map is still empty");
  return planner_.setGoal(graph_, x, y, *current_, *clock_);
}

std::vector<MapPose> ExperienceMap::pathToGoal() const {
  std::vector<MapPose> path;
  if (!current_) return path;
  for (const std::uint32_t id : planner_.path(*current_)) {
    if (path.empty()) path.push_back(robotPose());
    path.push_back(graph_.pose(id));
  }
  return path;
}

void ExperienceMap::checkAction(const TopologicalAction& action, const RecallGeometry* geometry) const {
  if (action.kind == ActionKind::kNone) return;
  const std::size_t experiences = graph_.experiences().size();
  const auto reject = [&](const std::string& why) {
    throw std::invalid_argument("action " + std::to_string(static_cast<std::uint32_t>(action.kind)) +
                                " from experience " + std::to_string(action.src_id) + " to " +
                                std::to_string(action.dest_id) + ": " + why);
  };
  if (!clock_) reject("the clock of the experience map has not been started");
  if (experiences > 0 && action.src_id >= experiences) {
    reject("there is no experience " + std::to_string(action.src_id));
  }
  if (action.kind == ActionKind::kCreateNode) {
    if (action.dest_id != experiences) reject("the next new experience is " + std::to_string(experiences));
  } else {
    if (action.dest_id >= experiences) reject("there is no experience " + std::to_string(action.dest_id));
    // Who is lost may be where it was last.
    if (!robot_.lost && action.dest_id == ignored_.value_or(*current_))
      reject("the robot is at that experience already");
  }
  if (!std::isfinite(action.relative_rad)) reject("relative_rad is not finite");
  if (geometry != nullptr && !finite(*geometry)) {
    reject("the geometry of the recall is not finite, or a standard deviation is not positive");
  }
}

void ExperienceMap::create(const RecallGeometry* geometry) {
  const MapPose pose = robotPose();
  const std::uint32_t id = graph_.addExperience(pose);
  if (!current_) {
    trajectory_.rebase(origin_, pose);
  } else if (!robot_.lost) {
    graph_.addLink(measuredLink(id, 0.0));
  }
  place(solver_->create(graph_, robot_, geometry));
  reach(id);
}

void ExperienceMap::place(const RobotPlace& placed) {
  // A stretch after unmeasured motion belongs to this place, not to the place before the gap.
  if (robot_.lost) {
    trajectory_.retie(current_since_, robot_.motion.pose, placed.frame, placed.motion.pose);
  }
  robot_ = placed;
}

void ExperienceMap::stayFrom(Stamp stamp) {
  current_since_ = stamp;
  stood_ns_ = 0;
}

void ExperienceMap::reach(std::uint32_t experience) {
  current_ = experience;
  ignored_.reset();
}

bool ExperienceMap::tellsPlace(const TopologicalAction& action) const {
  return action.kind != ActionKind::kSetNode || !solver_->corrects() || robot_.lost;
}

void ExperienceMap::locate(const TopologicalAction& action, const RecallGeometry* geometry) {
  if (action.kind != ActionKind::kCreateEdge && action.kind != ActionKind::kSetNode) return;
  if (tellsPlace(action)) place(solver_->locate(action.dest_id, action.relative_rad, geometry));
  reach(action.dest_id);
  stayFrom(*clock_);
  planner_.update(graph_, *current_, *clock_);
  record();
}

void ExperienceMap::recall(const TopologicalAction& action, const RecallGeometry* geometry) {
  const std::uint32_t id = action.dest_id;
  const bool was_lost = robot_.lost;
  // The robot may be there already: the pose cells come back from a recall that was ignored.
  const bool moves = id != *current_;
  Link link;
  if (moves && !was_lost) link = measuredLink(id, action.relative_rad);
  if (tellsPlace(action)) {
    const std::optional<RobotPlace> placed =
        solver_->recall(graph_, id, robot_, action.relative_rad, geometry);
    if (!placed) {
      ignored_ = id;
      return;
    }
    place(*placed);
  }
  if (action.kind == ActionKind::kCreateEdge && moves && !was_lost && !graph_.linked(*current_, id)) {
    link.recall = true;
    graph_.addLink(link);
  }
  reach(id);
}

Link ExperienceMap::measuredLink(std::uint32_t to, double relative_rad) const {
  const RelativePose measured = robot_.frame == solver_->frameOf(*current_)
                                    ? robot_.motion.pose
                                    : between(graph_.pose(*current_), robotPose());
  Link link;
  link.from = *current_;
  link.to = to;
  link.distance = std::hypot(measured.x, measured.y);
  link.heading_rad = std::atan2(measured.y, measured.x);
  link.facing_rad = wrapAngle(measured.yaw + (params_.relaxes() ? relative_rad : -relative_rad));
  link.rise = measured.z;
  // A goal's path takes no part of a stop on the way. OpenRatSLAM's arithmetic counts it.
  link.duration_s = secondsBetween(current_since_, *clock_) -
                    (params_.relaxes() ? 0.0 : 1e-9 * static_cast<double>(stood_ns_));
  return link;
}

MapPose ExperienceMap::framePose(std::uint32_t frame) const {
  return current_ ? solver_->framePose(graph_, frame) : origin_;
}

void ExperienceMap::record() {
  trajectory_.record(*clock_, robot_.frame, robot_.motion.pose, robotPose(), tilt_);
}

}  // namespace ratslam
