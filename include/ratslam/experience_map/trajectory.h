/// The robot's whole path, told twice: as it was estimated at the time, and as the present map sees it.
///
/// Each sample is tied to a frame of the map (an experience, or the place of a recall) by the pose relative
/// to it; when the map moves the frame, the path moves along.
#pragma once

#include <cstdint>
#include <vector>

#include "ratslam/experience_map/map_pose.h"

namespace ratslam {

class Trajectory {
 public:
  struct Sample {
    Stamp stamp = 0;
    std::uint32_t frame = 0;
    RelativePose relative;  ///< of the robot, in the axes of the frame

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("stamp", stamp);
      fields("frame", frame);
      fields("relative", relative);
    }
  };

  /// Appends a sample. One with the stamp of the newest takes its place: it is what was known at the end of
  /// that stamp.
  void record(Stamp stamp, std::uint32_t frame, const RelativePose& relative, const MapPose& online);

  /// Ties the samples that were given relative to `origin` to the first frame instead, placed at `first`.
  void rebase(const MapPose& origin, const MapPose& first);

  const std::vector<Sample>& samples() const { return samples_; }

  /// The poses as they were known at their stamps.
  const std::vector<StampedPose>& online() const { return online_; }

  /// The path in the present map; `pose_of(frame)` gives the frames' poses.
  template <class PoseOf>
  std::vector<StampedPose> path(PoseOf&& pose_of) const {
    std::vector<StampedPose> poses;
    poses.reserve(samples_.size());
    for (const Sample& sample : samples_) {
      poses.push_back({sample.stamp, compose(pose_of(sample.frame), sample.relative)});
    }
    return poses;
  }

  /// What it knows, for common/state.h.
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("samples", samples_);
    fields("online", online_);
  }

 private:
  std::vector<Sample> samples_;
  std::vector<StampedPose> online_;
};

}  // namespace ratslam
