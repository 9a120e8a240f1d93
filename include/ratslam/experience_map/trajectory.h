/// The robot's whole path in two forms: as it was estimated at the time, and in the present map.
///
/// Each sample holds the robot's pose relative to a frame of the map (an experience, or the place of a recall).
/// When the solver moves the frame, the sample moves with it.
///
/// A path with more than the allowed number of poses is thinned. A pose is dropped if interpolation between its
/// neighbours gives it within the tolerance. The tolerance starts at a millimetre (and a milliradian) and
/// doubles while there are too many poses. So a robot that stands still needs no memory, and the path of months
/// keeps its shape. The newest quarter is not thinned.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ratslam/experience_map/map_pose.h"

namespace ratslam {

class Trajectory {
 public:
  struct Sample {
    Stamp stamp = 0;
    std::uint32_t frame = 0;
    RelativePose relative;                                     ///< pose of the robot in the frame
    Eigen::Quaterniond tilt = Eigen::Quaterniond::Identity();  ///< attitude without the yaw

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("stamp", stamp);
      fields("frame", frame);
      fields("relative", relative);
      fields("tilt", tilt);
    }
  };

  /// @param most  largest number of poses; 0: unbounded
  explicit Trajectory(std::size_t most = 0) : most_(most) {}

  /// Appends a sample. A sample with the stamp of the newest one replaces it: the last estimate of a stamp
  /// counts.
  void record(Stamp stamp, std::uint32_t frame, const RelativePose& relative, const MapPose& online,
              const Eigen::Quaterniond& tilt = Eigen::Quaterniond::Identity());

  /// Expresses the samples that are relative to `origin` in the first frame, which lies at `first`.
  void rebase(const MapPose& origin, const MapPose& first);

  /// Expresses the samples from a stamp on in another frame. All of them must have the same frame before.
  /// @param robot_before  the robot's present pose in their frame  @param robot  the same pose in the new frame
  void retie(Stamp since, const RelativePose& robot_before, std::uint32_t frame, const RelativePose& robot);

  const std::vector<Sample>& samples() const { return samples_; }

  /// Index of the newest sample at or before a stamp; none before the first. If stamps have stepped back, only
  /// the samples since then are searched.
  std::optional<std::size_t> indexAt(Stamp stamp) const;

  /// A frame on a corrected stretch of the path.
  struct BentFrame {
    std::size_t sample = 0;  ///< first sample in this frame
    std::uint32_t frame = 0;
    RelativePose pose;  ///< in the axes of the robot where the stretch begins
  };

  /// Replaces the path after sample `first`. @param pose_of  pose_of(k) is the pose of sample k > first, in the
  /// axes of the robot at sample `first`. @return the frames made after that sample, in the order of the path
  template <class PoseOf>
  std::vector<BentFrame> bend(std::size_t first, PoseOf&& pose_of);

  /// The poses as they were known at their stamps.
  const std::vector<StampedPose>& online() const { return online_; }

  /// The path in the present map. @param pose_of  pose_of(frame) is the pose of a frame in the map
  template <class PoseOf>
  std::vector<StampedPose> path(PoseOf&& pose_of) const {
    std::vector<StampedPose> poses;
    poses.reserve(samples_.size());
    for (const Sample& sample : samples_) {
      poses.push_back({sample.stamp, compose(pose_of(sample.frame), sample.relative), sample.tilt});
    }
    return poses;
  }

  /// For common/state.h.
  template <class Fields>
  void stateFields(Fields&& fields) {
    fields("samples", samples_);
    fields("online", online_);
    fields("tolerance", tolerance_);
  }

 private:
  void thin();
  bool toldBy(std::size_t a, std::size_t b) const;

  std::size_t most_;
  double tolerance_ = 0.0;  ///< of the last thinning [m, rad]
  std::vector<Sample> samples_;
  std::vector<StampedPose> online_;
};

template <class PoseOf>
std::vector<Trajectory::BentFrame> Trajectory::bend(std::size_t first, PoseOf&& pose_of) {
  const auto asMapPose = [](const RelativePose& pose) {
    return MapPose{pose.x, pose.y, pose.z, pose.yaw, 0.0};
  };
  std::vector<BentFrame> frames;
  // The pose of the first frame in the axes of the robot at `first`.
  MapPose frame = asMapPose(between(asMapPose(samples_[first].relative), MapPose{}));
  for (std::size_t k = first + 1; k < samples_.size(); ++k) {
    Sample& sample = samples_[k];
    const RelativePose pose = pose_of(k);
    if (sample.frame != samples_[k - 1].frame) {
      frame = asMapPose(pose);  // a frame is created at the robot's pose
      frames.push_back({k, sample.frame, pose});
    }
    sample.relative = between(frame, asMapPose(pose));
  }
  return frames;
}

}  // namespace ratslam
