#include "ratslam/system/map_stage.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>

#include "ratslam/common/angles.h"
#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr std::uint32_t kStateVersion = 12;
constexpr std::uint32_t kUnknown = 0xFFFFFFFF;  // the map has no experience for a number of the pose cells

constexpr std::uint32_t kMostExperiences = 10'000'000;
constexpr std::size_t kMostGeometry = 20'000;  // bound on geometry that waits: the pose cells are dead then
constexpr std::size_t kMostWaypoints = 100'000;

}  // namespace

MapStage::MapStage(const ExperienceMapParams& params, GeometrySource geometry,
                   const OdometryStreamParams& stream)
    : map_(params),
      geometry_source_(geometry),
      use_height_(params.exp_height),
      stream_(stream),
      gate_(params.exp_height, stream, false) {}

bool MapStage::addDecision(const TopologicalAction& action) {
  EventVerdict verdict = gate_.addEvent(action);
  if (verdict == EventVerdict::kLate) {
    TopologicalAction now = action;
    now.stamp = *gate_.lastEvent();
    verdict = gate_.addEvent(now);
  }
  return verdict == EventVerdict::kAccepted;
}

void MapStage::addGeometry(const RecallGeometry& geometry) {
  geometry_.push_back(geometry);
  if (geometry_.size() <= kMostGeometry) return;
  useUpGeometry(1);
  ++forgotten_;
}

std::vector<Stamp> MapStage::drain(Passing which) {
  std::vector<Stamp> processed;
  if (which == Passing::kAll) gate_.acceptHeld();
  gate_.pass(which, [&](const TopologicalAction& action) {
    if (last_processed_ && action.stamp < *last_processed_) {
      started_ = false;  // the map's clock is set again: no motion and no time across the jump
      // What is left of the old time has no decision any more. That of the new time begins with an earlier stamp.
      const auto anew = std::find_if(geometry_.begin(), geometry_.end(), [this](const RecallGeometry& one) {
        return one.stamp <= *last_processed_;
      });
      useUpGeometry(static_cast<std::size_t>(anew - geometry_.begin()));
      used_geometry_.reset();
      last_processed_.reset();
    }
    if (which == Passing::kReached && geometryIsMissing(action.stamp)) return false;
    last_processed_ = action.stamp;
    if (processOrRefuse(action)) processed.push_back(action.stamp);
    return true;
  });
  return processed;
}

bool MapStage::geometryIsMissing(Stamp stamp) const {
  if (geometry_source_ == GeometrySource::kNone || earlierGeometry(stamp) < geometry_.size()) return false;
  // Geometry comes in the order of images. If a later one has come, this one was sent before the map started, and is
  // lost.
  const bool later_is_used = geometry_.empty() && used_geometry_ && *used_geometry_ >= stamp;
  return !later_is_used;
}

/// Number of the waiting geometries, from the oldest on, that are of images before `stamp` in the time of the decisions.
std::size_t MapStage::earlierGeometry(Stamp stamp) const {
  std::size_t count = 0;
  while (count < geometry_.size() && !beginsAnotherTime(count) && geometry_[count].stamp < stamp) ++count;
  return count;
}

bool MapStage::beginsAnotherTime(std::size_t index) const {
  const std::optional<Stamp> before = index == 0 ? used_geometry_ : geometry_[index - 1].stamp;
  return before && geometry_[index].stamp < *before;
}

/// Drops the oldest ones.
void MapStage::useUpGeometry(std::size_t count) {
  const auto end = geometry_.begin() + static_cast<std::ptrdiff_t>(count);
  for (auto used = geometry_.begin(); used != end; ++used) {
    used_geometry_ = used->stamp;
    if (used->view_id != kNoView) next_view_ = std::max(next_view_, used->view_id + 1);
  }
  geometry_.erase(geometry_.begin(), end);
}

bool MapStage::processOrRefuse(const TopologicalAction& action) {
  try {
    process(action);
    return true;
  } catch (const std::invalid_argument& e) {  // the decision is dropped; earlier ones are still returned
    refusals_.emplace_back(e.what());
  }
  return false;
}

std::vector<std::string> MapStage::takeRefusals() {
  std::vector<std::string> refusals;
  refusals.swap(refusals_);
  return refusals;
}

void MapStage::interrupt() {
  gate_ = EventGate<TopologicalAction>(use_height_, stream_, false);  // no decision may be lost
  beginnings_ = 0;
  useUpGeometry(geometry_.size());
  used_geometry_.reset();
  ahead_.reset();
  started_ = false;
  last_processed_.reset();
  map_.dropGoal();
}

void MapStage::save(State& state) const {
  state.setVersion(kStateVersion);
  map_.save(state.child("map"));
  state.set("streams", gate_);
  state.set("geometry", geometry_);
  state.set("used_geometry", used_geometry_);
  state.set("started", started_);
  state.set("last_processed", last_processed_);
  state.set("session", session_);
  state.set("experience_of", experience_of_);
  state.set("recreated", recreated_);
  state.set("beginnings", beginnings_);
  state.set("way", way_);
  state.set("way_yaw", way_yaw_);
  state.set("next_view", next_view_);
  state.set("oldest_view", oldest_view_);
}

void MapStage::load(const State& state) {
  state.requireVersion(kStateVersion);
  map_.load(state.child("map"));
  state.get("streams", gate_);
  state.get("geometry", geometry_);
  state.get("used_geometry", used_geometry_);
  state.get("started", started_);
  state.get("last_processed", last_processed_);
  state.get("session", session_);
  state.get("experience_of", experience_of_);
  state.get("recreated", recreated_);
  state.get("beginnings", beginnings_);
  state.get("way", way_);
  state.get("way_yaw", way_yaw_);
  state.get("next_view", next_view_);
  state.get("oldest_view", oldest_view_);
  ahead_.reset();
}

void MapStage::process(const TopologicalAction& action) {
  changes_.applyBefore(action.stamp, map_);
  ahead_.reset();
  if (!started_ || way_.empty() || beginnings_ != gate_.beginnings()) {
    const Stamp start = gate_.clockStart().value_or(action.stamp);
    map_.start(start);
    oldest_view_ = way_.empty() ? 0 : next_view_;
    way_.assign(1, Waypoint{start, way_.empty() ? Eigen::Vector3d(0, 0, 0) : way_.back().place});
    started_ = true;
    beginnings_ = gate_.beginnings();
  }
  Waypoint here = way_.back();
  for (const TimedStep& timed : gate_.motionUntil(action.stamp)) {
    map_.integrate(timed.end, timed.step);
    if (timed.correction) map_.correct(*timed.correction);
    way_yaw_ = wrapAngle(way_yaw_ + timed.step.rotation);
    const Eigen::Vector3d moved(timed.step.forward, timed.step.left, timed.step.up);
    here = {timed.end, here.place + Eigen::AngleAxisd(way_yaw_, Eigen::Vector3d::UnitZ()) * moved};
  }
  if (geometry_source_ == GeometrySource::kImages && here.stamp > way_.back().stamp) {
    way_.push_back(here);
    thinOutWay();
  }
  const std::optional<RecallGeometry> geometry = takeGeometry(action.stamp);
  if (action.kind == ActionKind::kNone) return;
  const TopologicalAction translated = inNumbersOfTheMap(action);
  map_.apply(translated, geometry ? &*geometry : nullptr);
  if (session_.id == 0 || translated.kind != ActionKind::kCreateNode || !map_.learning()) return;
  if (action.kind != ActionKind::kCreateNode) ++recreated_;
  if (action.dest_id >= experience_of_.size()) experience_of_.resize(action.dest_id + 1, kUnknown);
  experience_of_[action.dest_id] = translated.dest_id;
}

/// Converts the pose cells' numbers of experiences to those of the map. An action without a session belongs to the last
/// session; if there was none, its numbers are those of the map.
TopologicalAction MapStage::inNumbersOfTheMap(TopologicalAction action) {
  if (action.session.id == 0) action.session = session_;
  if (action.session.id == 0) return action;
  const auto known = [this](std::uint32_t id) {
    return id < experience_of_.size() && experience_of_[id] != kUnknown;
  };
  // A session gives each number once. Another one with the same first stamp, as of a drive that is played again, begins
  // with the first number.
  const bool begins_again = action.session == session_ && action.kind == ActionKind::kCreateNode &&
                            action.dest_id == session_.known && known(action.dest_id);
  if (action.session != session_ || begins_again) {
    if (session_.id == 0) {
      experience_of_.resize(map_.graph().experiences().size());
      std::iota(experience_of_.begin(), experience_of_.end(), 0U);
    }
    if (experience_of_.size() > action.session.known) experience_of_.resize(action.session.known);
    session_ = action.session;
  }
  const auto next = static_cast<std::uint32_t>(map_.graph().experiences().size());
  action.src_id = known(action.src_id) ? experience_of_[action.src_id] : map_.currentExperience().value_or(0);
  if (known(action.dest_id)) {
    action.dest_id = experience_of_[action.dest_id];
    return action;
  }
  action.kind = ActionKind::kCreateNode;
  if (action.dest_id >= kMostExperiences) {
    throw std::invalid_argument("action to experience " + std::to_string(action.dest_id) +
                                ": there is no such number of experiences");
  }
  action.dest_id = next;
  return action;
}

StampedPose MapStage::latestPose() {
  const OdometryTimeline& odometry = gate_.odometry();
  if (!ahead_ || ahead_->from != odometry.cursor() || ahead_->beginnings != gate_.beginnings())
    ahead_ = Ahead{gate_.beginnings(), odometry.cursor(), odometry.cursor(), Motion{}, map_.robotTilt()};
  for (const TimedStep& timed : odometry.lookAhead(ahead_->to)) {
    ahead_->motion.add(map_.inRobotsUnit(timed.step));
    ahead_->to = timed.end;
    ahead_->tilt = timed.step.tilt;
  }
  return {ahead_->to, compose(map_.robotPose(), ahead_->motion.pose), ahead_->tilt};
}

std::optional<RecallGeometry> MapStage::takeGeometry(Stamp stamp) {
  const std::size_t earlier = earlierGeometry(stamp);
  if (earlier == geometry_.size() || geometry_[earlier].stamp != stamp || beginsAnotherTime(earlier))
    return std::nullopt;
  RecallGeometry geometry = geometry_[earlier];
  useUpGeometry(earlier + 1);
  if (!geometry.measured()) return geometry.ahead != 0.0 ? std::make_optional(geometry) : std::nullopt;
  const auto from = odometryAt(geometry.companion_stamp);
  const auto to = odometryAt(geometry.template_stamp);
  const double way = from && to ? (*to - *from).norm() : 0.0;
  // Stamps of a template from before the way began are those of another clock.
  if (geometry.distance_ratio >= 0.0 && way > 0.0 && geometry.view_id >= oldest_view_) {
    geometry.distance = geometry.distance_ratio * way;
    geometry.sigma_distance = geometry.sigma_ratio * way;
  }
  return geometry;
}

void MapStage::thinOutWay() {
  if (way_.size() <= kMostWaypoints) return;
  std::size_t kept = 1;
  for (std::size_t k = 2; k < way_.size(); ++k) {
    if (k % 2 == 0 || k > way_.size() / 2) way_[kept++] = way_[k];
  }
  way_.resize(kept);
}

std::optional<Eigen::Vector3d> MapStage::odometryAt(Stamp stamp) const {
  const auto found =
      std::lower_bound(way_.begin(), way_.end(), stamp,
                       [](const Waypoint& waypoint, Stamp wanted) { return waypoint.stamp < wanted; });
  if (found == way_.end()) return std::nullopt;
  if (found->stamp == stamp) return found->place;
  if (found == way_.begin()) return std::nullopt;
  const Waypoint& before = *std::prev(found);
  const double share = secondsBetween(before.stamp, stamp) / secondsBetween(before.stamp, found->stamp);
  return before.place + share * (found->place - before.place);
}

}  // namespace ratslam
