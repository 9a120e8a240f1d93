#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>

#include "ratslam/common/state.h"
#include "ratslam/experience_map/experience_map.h"

namespace ratslam {

void ExperienceMap::save(State& state) const {
  graph_.save(state.child("graph"));
  solver_->save(state.child("solver"));
  state.set("trajectory", trajectory_);
  state.set("planner", planner_);
  state.set("robot", robot_);
  state.set("tilt", tilt_);
  state.set("current", current_);
  state.set("clock", clock_);
  state.set("ignored", ignored_);
  state.set("current_since", current_since_);
  state.set("stood_ns", stood_ns_);
  state.set("unit_sigma", unit_sigma_);
  state.set("bridged_steps", bridged_steps_);
}

void ExperienceMap::load(const State& state) {
  graph_.load(state.child("graph"));
  solver_->load(state.child("solver"));
  state.get("trajectory", trajectory_);
  state.get("planner", planner_);
  state.get("robot", robot_);
  state.get("tilt", tilt_);
  state.get("current", current_);
  state.get("clock", clock_);
  state.get("ignored", ignored_);
  state.get("current_since", current_since_);
  state.get("stood_ns", stood_ns_);
  state.get("unit_sigma", unit_sigma_);
  state.get("bridged_steps", bridged_steps_);
  if (current_.value_or(0) >= std::max<std::size_t>(graph_.experiences().size(), 1)) {
    throw std::runtime_error("state " + state.path() + "/current: there is no experience " +
                             std::to_string(*current_));
  }
}

std::unique_ptr<ExperienceMap> ExperienceMap::settled() const {
  State state;
  save(state);
  auto copy = std::make_unique<ExperienceMap>(params_);
  copy->load(state);
  copy->settle();
  return copy;
}

}  // namespace ratslam
