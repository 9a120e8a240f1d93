// Saving and loading of the odometry's state.
#include <stdexcept>

#include "ratslam/common/state.h"
#include "ratslam/odometry/orb/orb_odometry.h"

namespace ratslam {
namespace {

constexpr std::uint32_t kStateVersion = 4;

}  // namespace

void MotionBridge::save(State& state, FramesToSave& frames) const {
  state.set("from", from_);
  state.set("links", links_);
  state.set("last_frame_pose", last_frame_pose_);
  state.set("before", frames.number(before_));
  state.set("last_frame", frames.number(last_frame_));
  std::vector<StampedPoseOfCamera> way;
  std::vector<int> numbers;
  for (const Sample& sample : way_) {
    way.push_back({sample.stamp, sample.pose});
    numbers.push_back(frames.number(sample.frame));
  }
  state.set("way", way);
  state.set("way_frames", numbers);
}

MotionBridge MotionBridge::loaded(const State& state, const LoadedFrames& frames) {
  const auto from = state.get<StampedPoseOfCamera>("from");
  MotionBridge bridge(from.stamp, from.pose, frames.frame(state.get<int>("before")));
  state.get("links", bridge.links_);
  state.get("last_frame_pose", bridge.last_frame_pose_);
  bridge.last_frame_ = frames.frame(state.get<int>("last_frame"));
  const auto way = state.get<std::vector<StampedPoseOfCamera>>("way");
  const auto numbers = state.get<std::vector<int>>("way_frames");
  if (way.size() != numbers.size())
    throw std::runtime_error("state " + state.path() + ": each sample of the way has one frame or none");
  for (std::size_t i = 0; i < way.size(); ++i)
    bridge.way_.push_back({way[i].stamp, way[i].pose, frames.frame(numbers[i])});
  return bridge;
}

template <class Fields>
void OrbOdometry::stateFields(Fields&& fields) {
  fields("lens_model", camera_.model);
  fields("lens_coefficients", camera_.coefficients);
  fields("scale", scale_keeper_);
  fields("lens_refinement", lens_refinement_);
  fields("history", history_);
  fields("state", state_);
  fields("last_result", last_result_);
  fields("epoch", epoch_);
  fields("T_odom_camera", T_odom_camera_);
  fields("T_odom_world", T_odom_world_);
  fields("T_reference", T_reference_);
  fields("reference", reference_);
  fields("velocity", velocity_);
  fields("last_covariance", last_covariance_);
  fields("last_observations", last_observations_);
  fields("still_reference", still_reference_);
  fields("ignored_frames", ignored_frames_);
  fields("restarts", restarts_);
}

void OrbOdometry::save(State& state) const {
  state.setVersion(kStateVersion);
  const_cast<OrbOdometry*>(this)->stateFields(
      [&state](const std::string& name, const auto& value) { state.set(name, value); });
  FramesToSave frames;
  if (map_) map_->save(state.child("map"), frames);
  if (bridge_) bridge_->save(state.child("bridge"), frames);
  if (settling_) state.set("settling", *settling_);
  state.set("frame", frames.number(frame_));
  state.set("measured_frame", frames.number(measured_frame_));
  state.set("initialiser_reference", frames.number(initialiser_.reference()));
  state.set("initialiser", initialiser_.progress());
  frames.save(state.child("frames"));
}

void OrbOdometry::load(const State& state) {
  state.requireVersion(kStateVersion);
  stateFields([&state](const std::string& name, auto& value) { state.get(name, value); });
  camera_.validate();
  const LoadedFrames frames(state.child("frames"), camera_, extractor_, extractor_params_, *workers_);
  map_.reset();
  bridge_.reset();
  settling_.reset();
  if (state.hasChild("map")) map_.emplace(params_.map_keyframes).load(state.child("map"), frames);
  if (state.hasChild("bridge")) bridge_ = MotionBridge::loaded(state.child("bridge"), frames);
  if (state.hasChild("settling")) {
    settling_.emplace(Settling{history_, {}});
    state.get("settling", *settling_);
  }
  frame_ = frames.frame(state.get<int>("frame"));
  measured_frame_ = frames.frame(state.get<int>("measured_frame"));
  initialiser_.setCamera(camera_);
  initialiser_.resume(frames.frame(state.get<int>("initialiser_reference")),
                      state.get<MapInitialiser::Progress>("initialiser"));
  const auto missing = [&](KeyframeId id) { return !map_ || !map_->keyframe(id); };
  bool whole = !map_ || !missing(reference_);
  if (settling_) {
    whole = whole && bridge_;
    for (const Measured& sample : settling_->way) whole = whole && !missing(sample.reference);
  }
  if (!whole || (state_ != OrbState::kInitialising && (!map_ || !measured_frame_)))
    throw std::runtime_error("state " + state.path() + ": map, keyframes and frames do not fit together");
}

}  // namespace ratslam
