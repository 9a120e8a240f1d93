#include "ratslam/system/map_stage.h"

#include <algorithm>
#include <numeric>
#include <stdexcept>
#include <string>

#include "ratslam/common/angles.h"
#include "ratslam/common/state.h"

namespace ratslam {
namespace {

constexpr std::uint32_t kStateVersion = 10;
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
  geometry_[geometry.stamp] = geometry;
  newest_geometry_ = geometry.stamp;
  if (geometry.view_id != kNoView) newest_view_ = std::max(newest_view_, geometry.view_id);
  if (geometry_.size() <= kMostGeometry) return;
  geometry_.erase(geometry_.begin());
  ++forgotten_;
}

std::vector<Stamp> MapStage::drain(Passing which) {
  std::vector<Stamp> processed;
  if (which == Passing::kAll) gate_.acceptHeld();
  gate_.pass(which, [&](const TopologicalAction& action) {
    if (last_processed_ && action.stamp < *last_processed_) {
      started_ = false;  // the map's clock is set again: no motion and no time across the jump
      newest_geometry_.reset();
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
  // Geometry comes in the order of images. If a later one has come, this one was sent before the map started, and is lost.
  const bool will_come =
      geometry_source_ != GeometrySource::kNone && (!newest_geometry_ || stamp > *newest_geometry_);
  return will_come && geometry_.count(stamp) == 0;
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
  geometry_.clear();
  newest_geometry_.reset();
  started_ = false;
  last_processed_.reset();
  map_.dropGoal();
}

void MapStage::save(State& state) const {
  state.setVersion(kStateVersion);
  map_.save(state.child("map"));
  state.set("streams", gate_);
  std::vector<RecallGeometry> geometry;
  for (const auto& [stamp, measured] : geometry_) geometry.push_back(measured);
  state.set("geometry", geometry);
  state.set("newest_geometry", newest_geometry_);
  state.set("started", started_);
  state.set("last_processed", last_processed_);
  state.set("session", session_);
  state.set("experience_of", experience_of_);
  state.set("recreated", recreated_);
  state.set("beginnings", beginnings_);
  state.set("way", way_);
  state.set("way_yaw", way_yaw_);
  state.set("newest_view", newest_view_);
  state.set("oldest_view", oldest_view_);
}

void MapStage::load(const State& state) {
  state.requireVersion(kStateVersion);
  map_.load(state.child("map"));
  state.get("streams", gate_);
  geometry_.clear();
  for (const RecallGeometry& measured : state.get<std::vector<RecallGeometry>>("geometry")) {
    geometry_[measured.stamp] = measured;
  }
  state.get("newest_geometry", newest_geometry_);
  state.get("started", started_);
  state.get("last_processed", last_processed_);
  state.get("session", session_);
  state.get("experience_of", experience_of_);
  state.get("recreated", recreated_);
  state.get("beginnings", beginnings_);
  state.get("way", way_);
  state.get("way_yaw", way_yaw_);
  state.get("newest_view", newest_view_);
  state.get("oldest_view", oldest_view_);
}

void MapStage::process(const TopologicalAction& action) {
  changes_.applyBefore(action.stamp, map_);
  if (!started_ || way_.empty() || beginnings_ != gate_.beginnings()) {
    const Stamp start = gate_.clockStart().value_or(action.stamp);
    map_.start(start);
    oldest_view_ = way_.empty() ? 0 : newest_view_;
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
  if (session_.id == 0 || translated.kind != ActionKind::kCreateNode) return;
  if (action.kind != ActionKind::kCreateNode) ++recreated_;
  if (action.dest_id >= experience_of_.size()) experience_of_.resize(action.dest_id + 1, kUnknown);
  experience_of_[action.dest_id] = translated.dest_id;
}

/// Converts the pose cells' numbers of experiences to those of the map. An action without a session belongs to the last
/// session; if there was none, its numbers are those of the map.
TopologicalAction MapStage::inNumbersOfTheMap(TopologicalAction action) {
  if (action.session.id == 0) action.session = session_;
  if (action.session.id == 0) return action;
  if (action.session != session_) {
    if (session_.id == 0) {
      experience_of_.resize(map_.graph().experiences().size());
      std::iota(experience_of_.begin(), experience_of_.end(), 0U);
    }
    if (experience_of_.size() > action.session.known) experience_of_.resize(action.session.known);
    session_ = action.session;
  }
  const auto known = [this](std::uint32_t id) {
    return id < experience_of_.size() && experience_of_[id] != kUnknown;
  };
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

StampedPose MapStage::latestPose() const {
  StampedPose latest{gate_.odometry().cursor(), map_.robotPose(), map_.robotTilt()};
  const std::optional<Stamp> newest = gate_.odometry().lastStamp();
  if (!newest) return latest;
  Motion motion;
  for (const TimedStep& timed : gate_.odometry().lookAhead(*newest)) {
    motion.add(map_.inRobotsUnit(timed.step));
    latest.stamp = timed.end;
    latest.tilt = timed.step.tilt;
  }
  latest.pose = compose(latest.pose, motion.pose);
  return latest;
}

std::optional<RecallGeometry> MapStage::takeGeometry(Stamp stamp) {
  const auto found = geometry_.find(stamp);
  if (found == geometry_.end()) return std::nullopt;
  RecallGeometry geometry = found->second;
  geometry_.erase(geometry_.begin(), std::next(found));
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
