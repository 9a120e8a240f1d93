#include "ratslam/experience_map/experience_map.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "ratslam/common/state.h"
#include "ratslam/experience_map/solver/pose_graph_map.h"
#include "ratslam/experience_map/solver/relaxation.h"

namespace ratslam {
namespace {

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
         g.sigma_direction > 0.0;
}

}  // namespace

ExperienceMap::ExperienceMap(const ExperienceMapParams& params)
    : params_(validated(params)),
      solver_(makeSolver(params_)),
      planner_(params_.exp_goal_radius, params_.exp_goal_timeout) {
  origin_.yaw = wrapAngle(degreesToRadians(params_.exp_initial_em_deg));
}

void ExperienceMap::start(Stamp stamp) {
  current_since_ = clock_ ? stamp - (*clock_ - current_since_) : stamp;
  robot_.lost = current_.has_value();
  clock_ = stamp;
  record();
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
  OdometryStep carried = step;
  if (!params_.exp_height) carried.up = 0.0;
  robot_.motion.add(carried);
  clock_ = end;
  solver_->resume(graph_);
  if (current_) planner_.update(graph_, *current_, *clock_);
  record();
}

void ExperienceMap::apply(const TopologicalAction& action, const RecallGeometry* geometry) {
  checkAction(action, geometry);
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
  current_since_ = *clock_;
  solver_->update(graph_, robot_);
  planner_.update(graph_, *current_, *clock_);
  record();
}

void ExperienceMap::settle() { solver_->settle(graph_); }

MapPose ExperienceMap::robotPose() const { return compose(framePose(robot_.frame), robot_.motion.pose); }

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

void ExperienceMap::save(State& state) const {
  graph_.save(state.child("graph"));
  solver_->save(state.child("solver"));
  state.set("trajectory", trajectory_);
  state.set("planner", planner_);
  state.set("robot", robot_);
  state.set("current", current_);
  state.set("clock", clock_);
  state.set("current_since", current_since_);
}

void ExperienceMap::load(const State& state) {
  graph_.load(state.child("graph"));
  solver_->load(state.child("solver"));
  state.get("trajectory", trajectory_);
  state.get("planner", planner_);
  state.get("robot", robot_);
  state.get("current", current_);
  state.get("clock", clock_);
  state.get("current_since", current_since_);
  if (current_.value_or(0) >= std::max<std::size_t>(graph_.experiences().size(), 1)) {
    throw std::runtime_error("state " + state.path() + "/current: there is no experience " +
                             std::to_string(*current_));
  }
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
    if (action.dest_id == *current_) reject("the robot is at that experience already");
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
  robot_ = solver_->create(graph_, robot_, geometry);
  current_ = id;
}

void ExperienceMap::recall(const TopologicalAction& action, const RecallGeometry* geometry) {
  const std::uint32_t id = action.dest_id;
  if (action.kind == ActionKind::kCreateEdge && !robot_.lost && !graph_.linked(*current_, id)) {
    Link link = measuredLink(id, action.relative_rad);
    link.recall = true;
    graph_.addLink(link);
  }
  robot_ = solver_->recall(graph_, id, robot_, action.relative_rad, geometry);
  current_ = id;
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
  link.duration_s = secondsBetween(current_since_, *clock_);
  return link;
}

MapPose ExperienceMap::framePose(std::uint32_t frame) const {
  return current_ ? solver_->framePose(graph_, frame) : origin_;
}

void ExperienceMap::record() { trajectory_.record(*clock_, robot_.frame, robot_.motion.pose, robotPose()); }

}  // namespace ratslam
