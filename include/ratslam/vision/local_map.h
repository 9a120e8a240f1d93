/// The local map: the last keyframes and the landmarks that they observe. Its size is bounded: a new keyframe beyond
/// the window removes the oldest one, and a landmark is removed with its last observations. It closes no loops.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <unordered_map>
#include <vector>

#include "ratslam/vision/frame.h"
#include "ratslam/vision/frame_state.h"

namespace ratslam {

using KeyframeId = int;
using Descriptor = std::array<std::uint8_t, 32>;

/// Observation of a landmark in a keyframe.
struct LandmarkObservation {
  KeyframeId keyframe = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted
  double sigma = 1.0;                               ///< relative to level 0
  int strikes = 0;  ///< consecutive bundle adjustments in which it was an outlier
};

struct Landmark {
  LandmarkId id = kNoLandmark;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< world
  Descriptor descriptor{};
  std::vector<LandmarkObservation> observations;  ///< keyframes ascending
  KeyframeId reference = 0;                       ///< keyframe whose image gives the landmark's patch
  Eigen::Vector2d reference_raw = Eigen::Vector2d::Zero();
  int reference_level = 0;
  KeyframeId created = 0;
  int visible = 0;  ///< number of frames in which it should be visible
  int found = 0;    ///< number of frames in which it was found

  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("id", id);
    fields("position", position);
    fields("descriptor", descriptor);
    fields("reference", reference);
    fields("reference_raw", reference_raw);
    fields("reference_level", reference_level);
    fields("created", created);
    fields("visible", visible);
    fields("found", found);
    // As lists of plain values they fit into the rows of a table.
    std::vector<KeyframeId> keyframes;
    std::vector<Eigen::Vector2d> pixels;
    std::vector<double> sigmas;
    std::vector<int> strikes;
    for (const LandmarkObservation& seen : observations) {
      keyframes.push_back(seen.keyframe);
      pixels.push_back(seen.pixel);
      sigmas.push_back(seen.sigma);
      strikes.push_back(seen.strikes);
    }
    fields("seen_by", keyframes);
    fields("seen_at", pixels);
    fields("seen_sigma", sigmas);
    fields("strikes", strikes);
    observations.clear();
    for (std::size_t i = 0; i < std::min({keyframes.size(), pixels.size(), sigmas.size(), strikes.size()});
         ++i)
      observations.push_back({keyframes[i], pixels[i], sigmas[i], strikes[i]});
  }
};

struct Keyframe {
  KeyframeId id = 0;
  std::shared_ptr<Frame> frame;
};

class LocalMap {
 public:
  /// @param max_keyframes at least 2.
  explicit LocalMap(int max_keyframes) : max_keyframes_(max_keyframes) {}

  const std::deque<Keyframe>& keyframes() const { return keyframes_; }
  /// Whether the next keyframe will remove the oldest one.
  bool full() const { return static_cast<int>(keyframes_.size()) >= max_keyframes_; }
  /// A keyframe; null if it has been removed.
  const Keyframe* keyframe(KeyframeId id) const;
  std::vector<Landmark>& landmarks() { return landmarks_; }
  const std::vector<Landmark>& landmarks() const { return landmarks_; }
  /// A landmark; null if it has been removed. Valid until landmarks are added or removed.
  Landmark* landmark(LandmarkId id);
  const Landmark* landmark(LandmarkId id) const;

  /// Adds a keyframe and its observations. Removes the oldest keyframes beyond the window.
  const Keyframe& addKeyframe(std::shared_ptr<Frame> frame, const CameraModel& camera);
  /// @param landmark without an id. @return its id.
  LandmarkId addLandmark(Landmark landmark);
  /// Removes the landmarks for which `unwanted(landmark)` is true, and all with fewer than two observations.
  template <class Predicate>
  void removeLandmarks(Predicate&& unwanted) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < landmarks_.size(); ++i) {
      if (landmarks_[i].observations.size() < 2 || unwanted(landmarks_[i])) continue;
      if (kept != i) landmarks_[kept] = std::move(landmarks_[i]);
      ++kept;
    }
    landmarks_.resize(kept);
    reindex();
  }

  /// Scales all poses and positions about `centre`.
  void rescale(double factor, const Eigen::Vector3d& centre);
  /// Undistorts all observations with another calibration. Poses and positions do not change.
  void recalibrate(const CameraModel& from, const CameraModel& to);
  /// Median depth of the landmarks in front of a camera; 0 if there are none.
  double medianDepth(const RigidTransform& T_camera_world) const;

  void save(State& state, FramesToSave& frames) const;
  /// @throws std::runtime_error naming what is missing or does not fit together
  void load(const State& state, const LoadedFrames& frames);

 private:
  void dropOldestKeyframe(const CameraModel& camera);
  void reindex();

  int max_keyframes_;
  KeyframeId next_keyframe_ = 0;
  LandmarkId next_landmark_ = 0;
  std::deque<Keyframe> keyframes_;   // ids without gaps
  std::vector<Landmark> landmarks_;  // ids ascending
  std::unordered_map<LandmarkId, std::size_t> index_;
};

}  // namespace ratslam
