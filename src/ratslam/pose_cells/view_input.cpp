#include "ratslam/pose_cells/view_input.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "ratslam/common/angles.h"
#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr std::size_t kTooYoung = 10;      // the newest ids do not inject: the robot is still there
constexpr double kSaturationScale = 30.0;  // exp(1.2 d) = 30 at d = 2.83, where injection ends
constexpr double kSaturationGrowth = 1.2;

}  // namespace

std::optional<Injection> ViewInput::onView(const ViewEvent& event, const PoseCellEstimate& estimate) {
  std::optional<Injection> injection;
  const auto [found, is_new] = ties_.try_emplace(event.id);
  Tie& tie = found->second;
  if (is_new) {
    tie = {estimate, params_.active_decay, events_, ties_.size() - 1};
  } else if (tie.order < known_before_ || tie.order + kTooYoung < ties_.size()) {
    injection = recall(tie, event);
  }
  previous_id_ = event.id;
  ++events_;
  return injection;
}

std::optional<Injection> ViewInput::recall(Tie& tie, const ViewEvent& event) const {
  restore(tie);
  if (previous_id_ == event.id) tie.saturation += params_.active_decay;
  const double energy = params_.inject_energy *
                        (kSaturationScale - std::exp(kSaturationGrowth * tie.saturation)) / kSaturationScale;
  if (!(energy > 0.0)) return std::nullopt;
  const double turned = wrapAngle(event.relative_rad) * params_.n_th / (2.0 * kPi);
  const double layer = wrapCoordinate(tie.where.th + turned, params_.n_th);
  Injection injection{{tie.where.x, tie.where.y, layer}, energy};
  if (params_.openratslam_injection) {
    injection.where = {std::trunc(tie.where.x), std::trunc(tie.where.y), std::trunc(layer)};
  }
  return injection;
}

void ViewInput::wakeUp() {
  known_before_ = ties_.size();
  previous_id_.reset();
  for (auto& [id, tie] : ties_) {
    tie.saturation = params_.active_decay;
    tie.updated = events_;
  }
}

void ViewInput::forgetFrom(std::uint32_t view_id) {
  for (auto it = ties_.begin(); it != ties_.end();)
    it = it->first >= view_id ? ties_.erase(it) : std::next(it);
  std::vector<Tie*> left;
  for (auto& [id, tie] : ties_) left.push_back(&tie);
  std::sort(left.begin(), left.end(), [](const Tie* a, const Tie* b) { return a->order < b->order; });
  known_before_ = static_cast<std::uint64_t>(
      std::count_if(left.begin(), left.end(), [this](const Tie* tie) { return tie->order < known_before_; }));
  for (std::size_t i = 0; i < left.size(); ++i) left[i]->order = i;
  if (previous_id_ && *previous_id_ >= view_id) previous_id_.reset();
}

void ViewInput::save(State& state) const {
  std::vector<TiedView> ties;
  for (const auto& [id, tie] : ties_) ties.push_back({id, tie});
  std::sort(ties.begin(), ties.end(),
            [](const TiedView& a, const TiedView& b) { return a.tie.order < b.tie.order; });
  state.set("view_links", ties);
  state.set("previous_id", previous_id_);
  state.set("events", events_);
  state.set("known_before", known_before_);
}

void ViewInput::load(const State& state) {
  ties_.clear();
  for (const TiedView& tied : state.get<std::vector<TiedView>>("view_links")) ties_[tied.view_id] = tied.tie;
  state.get("previous_id", previous_id_);
  state.get("events", events_);
  state.get("known_before", known_before_);
}

/// Subtracts repeatedly instead of multiplying: so the bits equal those of an update at each event. An id that
/// has not been repeated is at rest and takes no step.
void ViewInput::restore(Tie& tie) const {
  for (; tie.updated < events_; ++tie.updated) {
    const double restored = std::max(params_.active_decay, tie.saturation - params_.restore);
    if (restored == tie.saturation) break;
    tie.saturation = restored;
  }
  tie.updated = events_;
}

}  // namespace ratslam
