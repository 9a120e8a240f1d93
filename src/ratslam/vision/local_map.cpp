#include "ratslam/vision/local_map.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "ratslam/common/state.h"
#include "ratslam/common/statistics.h"

namespace ratslam {

const Keyframe* LocalMap::keyframe(KeyframeId id) const {
  if (keyframes_.empty() || id < keyframes_.front().id || id > keyframes_.back().id) return nullptr;
  return &keyframes_[static_cast<std::size_t>(id - keyframes_.front().id)];
}

Landmark* LocalMap::landmark(LandmarkId id) {
  const auto found = index_.find(id);
  return found == index_.end() ? nullptr : &landmarks_[found->second];
}

const Landmark* LocalMap::landmark(LandmarkId id) const {
  const auto found = index_.find(id);
  return found == index_.end() ? nullptr : &landmarks_[found->second];
}

const Keyframe& LocalMap::addKeyframe(std::shared_ptr<Frame> frame, const CameraModel& camera) {
  const KeyframeId id = next_keyframe_++;
  for (const Observation& observation : frame->observations) {
    if (Landmark* seen = landmark(observation.landmark)) {
      seen->observations.push_back({id, observation.pixel, observation.sigma, 0});
    }
  }
  keyframes_.push_back({id, std::move(frame)});
  while (static_cast<int>(keyframes_.size()) > max_keyframes_) dropOldestKeyframe(camera);
  return keyframes_.back();
}

LandmarkId LocalMap::addLandmark(Landmark landmark) {
  landmark.id = next_landmark_++;
  index_[landmark.id] = landmarks_.size();
  landmarks_.push_back(std::move(landmark));
  return landmarks_.back().id;
}

void LocalMap::dropOldestKeyframe(const CameraModel& camera) {
  const KeyframeId gone = keyframes_.front().id;
  keyframes_.pop_front();
  for (Landmark& landmark : landmarks_) {
    auto& observations = landmark.observations;
    if (!observations.empty() && observations.front().keyframe == gone)
      observations.erase(observations.begin());
    if (landmark.reference != gone || observations.empty()) continue;
    // The newest view stays longest. So the reference changes rarely; each change could add a small error.
    const LandmarkObservation& newest = observations.back();
    const ImagePyramid& pyramid = keyframe(newest.keyframe)->frame->pyramid;
    landmark.reference = newest.keyframe;
    landmark.reference_raw = camera.distort(newest.pixel);
    landmark.reference_level = 0;
    while (landmark.reference_level + 1 < pyramid.levels() &&
           pyramid.scale(landmark.reference_level) < 0.95 * newest.sigma) {
      ++landmark.reference_level;
    }
  }
  removeLandmarks([](const Landmark&) { return false; });
}

void LocalMap::reindex() {
  index_.clear();
  for (std::size_t i = 0; i < landmarks_.size(); ++i) index_[landmarks_[i].id] = i;
}

void LocalMap::rescale(double factor, const Eigen::Vector3d& centre) {
  for (Landmark& landmark : landmarks_) landmark.position = centre + factor * (landmark.position - centre);
  for (const Keyframe& keyframe : keyframes_) {
    RigidTransform& pose = keyframe.frame->T_camera_world;
    const Eigen::Vector3d moved = centre + factor * (keyframe.frame->centre() - centre);
    pose.translation = -(pose.rotation * moved);
  }
}

void LocalMap::recalibrate(const CameraModel& from, const CameraModel& to) {
  for (const Keyframe& keyframe : keyframes_) ratslam::recalibrate(*keyframe.frame, from, to);
  for (Landmark& landmark : landmarks_) {
    for (LandmarkObservation& seen : landmark.observations)
      seen.pixel = to.undistort(from.distort(seen.pixel), seen.pixel);
  }
}

void LocalMap::save(State& state, FramesToSave& frames) const {
  state.set("next_keyframe", next_keyframe_);
  state.set("next_landmark", next_landmark_);
  std::vector<int> numbers;
  for (const Keyframe& keyframe : keyframes_) numbers.push_back(frames.number(keyframe.frame));
  state.set("keyframes", numbers);
  state.set("landmarks", landmarks_);
}

void LocalMap::load(const State& state, const LoadedFrames& frames) {
  state.get("next_keyframe", next_keyframe_);
  state.get("next_landmark", next_landmark_);
  state.get("landmarks", landmarks_);
  const auto numbers = state.get<std::vector<int>>("keyframes");
  keyframes_.clear();
  // Ids have no gaps and end with the newest one.
  KeyframeId id = next_keyframe_ - static_cast<KeyframeId>(numbers.size());
  for (const int number : numbers) keyframes_.push_back({id++, frames.frame(number)});
  const bool whole = !keyframes_.empty() &&
                     std::all_of(keyframes_.begin(), keyframes_.end(),
                                 [](const Keyframe& k) { return k.frame != nullptr; }) &&
                     std::all_of(landmarks_.begin(), landmarks_.end(), [&](const Landmark& landmark) {
                       const Keyframe* reference = keyframe(landmark.reference);
                       return reference != nullptr && landmark.reference_level >= 0 &&
                              landmark.reference_level < reference->frame->pyramid.levels() &&
                              std::all_of(landmark.observations.begin(), landmark.observations.end(),
                                          [&](const auto& seen) { return keyframe(seen.keyframe); });
                     });
  if (!whole)
    throw std::runtime_error("state " + state.path() + ": keyframes and landmarks do not fit together");
  reindex();
}

double LocalMap::medianDepth(const RigidTransform& T_camera_world) const {
  std::vector<double> depths;
  for (const Landmark& landmark : landmarks_) {
    const double depth = (T_camera_world * landmark.position).z();
    if (depth > 0.0) depths.push_back(depth);
  }
  return depths.empty() ? 0.0 : median(std::move(depths));
}

}  // namespace ratslam
