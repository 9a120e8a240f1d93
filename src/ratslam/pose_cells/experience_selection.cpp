#include "ratslam/pose_cells/experience_selection.h"

#include <cmath>

#include "ratslam/common/angles.h"
#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr std::uint32_t kForgotten = 0xFFFFFFFF;  // view_id of an experience whose view cell was forgotten

}  // namespace

TopologicalAction ExperienceSelector::select(const ViewEvent& view, const PoseCellEstimate& estimate) {
  TopologicalAction action;
  action.stamp = view.stamp;
  action.src_id = current_;
  // The current experience has the view cell of the last decision, because every change of the view cell leads
  // to step 1 or 2.
  const bool other_view = nowhere_ || experiences_.empty() || experiences_[current_].view_id != view.id;
  if (other_view || distance(view, estimate, experiences_[current_]) > reach(experiences_[current_])) {
    const std::optional<std::uint32_t> match = nearestOther(view, estimate, other_view);
    if (!match && !learning_) return stay(view.stamp);
    // While one view stays active only odometry tells places apart, so kSetNode and not a recall.
    const bool seen = other_view || params_.experience_density == 0.0;
    action.kind = !match ? ActionKind::kCreateNode : seen ? ActionKind::kCreateEdge : ActionKind::kSetNode;
    current_ = match ? *match : create(view, estimate, seen);
    nowhere_ = false;
    if (match && learning_ && params_.experience_density > 0.0) ++experiences_[current_].visits;
  }
  action.dest_id = current_;
  action.relative_rad = relativeHeading(view, experiences_[current_]);
  return action;
}

TopologicalAction ExperienceSelector::stay(Stamp stamp) const {
  TopologicalAction action;
  action.stamp = stamp;
  action.src_id = action.dest_id = current_;
  return action;
}

double ExperienceSelector::relativeHeading(const ViewEvent& view, const Experience& experience) const {
  return wrapAngle(view.relative_rad - experience.relative_rad);
}

double ExperienceSelector::distance(const ViewEvent& view, const PoseCellEstimate& estimate,
                                    const Experience& experience) const {
  const double turned = relativeHeading(view, experience) * params_.n_th / (2.0 * kPi);
  const double dx = std::remainder(estimate.x - experience.where.x, params_.n_xy);
  const double dy = std::remainder(estimate.y - experience.where.y, params_.n_xy);
  const double dth = std::remainder(estimate.th - turned - experience.where.th, params_.n_th);
  return std::sqrt(dx * dx + dy * dy + dth * dth);
}

std::optional<std::uint32_t> ExperienceSelector::nearestOther(const ViewEvent& view,
                                                              const PoseCellEstimate& estimate,
                                                              bool recognised) const {
  const auto candidates = of_view_.find(view.id);
  if (candidates == of_view_.end()) return std::nullopt;
  std::optional<std::uint32_t> nearest;
  double nearest_distance = params_.experience_distance;
  for (const std::uint32_t id : candidates->second) {
    if ((id == current_ && !nowhere_) || (recognised && !experiences_[id].recognisable)) continue;
    const double d = distance(view, estimate, experiences_[id]);
    if (d < nearest_distance && d < reach(experiences_[id])) {
      nearest = id;
      nearest_distance = d;
    }
  }
  return nearest;
}

double ExperienceSelector::reach(const Experience& experience) const {
  return params_.experience_distance / (1.0 + params_.experience_density * std::log1p(experience.visits));
}

std::uint32_t ExperienceSelector::visitsAround(const ViewEvent& view,
                                               const PoseCellEstimate& estimate) const {
  const auto around = of_view_.find(view.id);
  if (params_.experience_density == 0.0 || around == of_view_.end()) return 0;
  std::uint32_t visits = 0;
  double nearest_distance = params_.experience_distance;
  for (const std::uint32_t id : around->second) {
    const double d = distance(view, estimate, experiences_[id]);
    if (d >= nearest_distance) continue;
    visits = experiences_[id].visits;
    nearest_distance = d;
  }
  return visits;
}

std::uint32_t ExperienceSelector::create(const ViewEvent& view, const PoseCellEstimate& estimate,
                                         bool recognisable) {
  const auto id = static_cast<std::uint32_t>(experiences_.size());
  experiences_.push_back({estimate, view.id, view.relative_rad, visitsAround(view, estimate), recognisable});
  of_view_[view.id].push_back(id);
  return id;
}

std::optional<PlaceView> ExperienceSelector::viewOf(std::uint32_t experience) const {
  const Experience& there = experiences_.at(experience);
  if (there.view_id == kForgotten) return std::nullopt;
  return PlaceView{there.view_id, there.relative_rad};
}

void ExperienceSelector::forgetViewsFrom(std::uint32_t view_id) {
  for (Experience& experience : experiences_) {
    if (experience.view_id >= view_id) experience.view_id = kForgotten;
  }
  indexViews();
}

void ExperienceSelector::indexViews() {
  of_view_.clear();
  for (std::uint32_t id = 0; id < experiences_.size(); ++id) {
    if (experiences_[id].view_id != kForgotten) of_view_[experiences_[id].view_id].push_back(id);
  }
}

void ExperienceSelector::save(State& state) const {
  state.set("selection", experiences_);
  state.set("current", current_);
  state.set("nowhere", nowhere_);
  if (params_.experience_density == 0.0) return;
  std::vector<std::uint8_t> recognisable;
  for (const Experience& experience : experiences_) recognisable.push_back(experience.recognisable ? 1 : 0);
  state.set("recognisable", recognisable);
}

void ExperienceSelector::load(const State& state) {
  auto experiences = state.get<std::vector<Experience>>("selection");
  const auto current = state.get<std::uint32_t>("current");
  if (!experiences.empty() && current >= experiences.size()) {
    throw std::runtime_error("state " + state.path() + "/current: there is no experience " +
                             std::to_string(current));
  }
  if (params_.experience_density > 0.0) {
    const auto recognisable = state.get<std::vector<std::uint8_t>>("recognisable");
    if (recognisable.size() != experiences.size()) {
      throw std::runtime_error("state " + state.path() + "/recognisable: it says " +
                               std::to_string(recognisable.size()) + " times whether one of " +
                               std::to_string(experiences.size()) + " experiences is");
    }
    for (std::size_t id = 0; id < experiences.size(); ++id) {
      experiences[id].recognisable = recognisable[id] != 0;
    }
  }
  experiences_ = std::move(experiences);
  current_ = current;
  state.get("nowhere", nowhere_);
  indexViews();
}

}  // namespace ratslam
