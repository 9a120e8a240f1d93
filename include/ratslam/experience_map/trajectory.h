/// The robot's whole path, told twice: as it was estimated at the time, and as the present map sees it.
///
/// Each sample is tied to a frame of the map (an experience, or the place of a recall) by the pose relative
/// to it; when the map moves the frame, the path moves along.
///
/// A path of more poses than there may be is thinned: one is left out where the path between its neighbours tells
/// it, moving evenly, as well as the tolerance asks, which starts at a millimetre (and a milliradian) and doubles
/// as long as there are too many. So a robot that stands still costs nothing, and one that drives for months
/// keeps the shape of all its way. The newest quarter is kept as it is.
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
    RelativePose relative;                                     ///< of the robot, in the axes of the frame
    Eigen::Quaterniond tilt = Eigen::Quaterniond::Identity();  ///< attitude but for the yaw

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("stamp", stamp);
      fields("frame", frame);
      fields("relative", relative);
      fields("tilt", tilt);
    }
  };

  /// @param most  poses that are kept; 0: all
  explicit Trajectory(std::size_t most = 0) : most_(most) {}

  /// Appends a sample. One with the stamp of the newest takes its place: it is what was known at the end of
  /// that stamp.
  void record(Stamp stamp, std::uint32_t frame, const RelativePose& relative, const MapPose& online,
              const Eigen::Quaterniond& tilt = Eigen::Quaterniond::Identity());

  /// Ties the samples that were given relative to `origin` to the first frame instead, placed at `first`.
  void rebase(const MapPose& origin, const MapPose& first);

  /// Ties the samples from a stamp on, all of which have one frame, to another one. @param robot_before  the robot now, in
  /// the axes of their frame. @param robot  the same in those of the other
  void retie(Stamp since, const RelativePose& robot_before, std::uint32_t frame, const RelativePose& robot);

  const std::vector<Sample>& samples() const { return samples_; }

  /// The newest sample at or before a stamp, none before the first. Where stamps have gone back, of the newest
  /// stretch of time.
  std::optional<std::size_t> indexAt(Stamp stamp) const;

  /// A frame within a stretch that is laid anew, in the axes of the robot where the stretch begins.
  struct BentFrame {
    std::size_t sample = 0;  ///< at which it was made
    std::uint32_t frame = 0;
    RelativePose pose;
  };

  /// Lays the path anew from a sample on. @param pose_of  pose(k) of sample k > first, in the axes of the robot
  /// at sample `first`. @return the frames that were made since, in the order of the way
  template <class PoseOf>
  std::vector<BentFrame> bend(std::size_t first, PoseOf&& pose_of);

  /// The poses as they were known at their stamps.
  const std::vector<StampedPose>& online() const { return online_; }

  /// The path in the present map; `pose_of(frame)` gives the frames' poses.
  template <class PoseOf>
  std::vector<StampedPose> path(PoseOf&& pose_of) const {
    std::vector<StampedPose> poses;
    poses.reserve(samples_.size());
    for (const Sample& sample : samples_) {
      poses.push_back({sample.stamp, compose(pose_of(sample.frame), sample.relative), sample.tilt});
    }
    return poses;
  }

  /// What it knows, for common/state.h.
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
  double tolerance_ = 0.0;  ///< of what was left out so far [m, rad]
  std::vector<Sample> samples_;
  std::vector<StampedPose> online_;
};

template <class PoseOf>
std::vector<Trajectory::BentFrame> Trajectory::bend(std::size_t first, PoseOf&& pose_of) {
  const auto asMapPose = [](const RelativePose& pose) {
    return MapPose{pose.x, pose.y, pose.z, pose.yaw, 0.0};
  };
  std::vector<BentFrame> frames;
  // The first frame lies where the robot at `first` was seen from it.
  MapPose frame = asMapPose(between(asMapPose(samples_[first].relative), MapPose{}));
  for (std::size_t k = first + 1; k < samples_.size(); ++k) {
    Sample& sample = samples_[k];
    const RelativePose pose = pose_of(k);
    if (sample.frame != samples_[k - 1].frame) {
      frame = asMapPose(pose);  // a frame is made where the robot is
      frames.push_back({k, sample.frame, pose});
    }
    sample.relative = between(frame, asMapPose(pose));
  }
  return frames;
}

}  // namespace ratslam
