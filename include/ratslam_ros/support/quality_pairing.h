/// Joins odometry with what comes beside it on a topic of its own.
///
/// Both topics hold one message a sample, in the same order, but either may run ahead of the other, by more than a lap of
/// a looped recording: so the two are paired in the order of their arrival, not by the stamp alone.
#pragma once

#include <deque>
#include <optional>

#include "ratslam/odometry/odometry.h"
#include "ratslam_ros/OdometryQuality.h"

namespace ratslam {

class QualityPairing {
 public:
  void hearSample(const OdometrySample& sample) { samples_.push_back(sample); }
  void hearQuality(const ratslam_ros::OdometryQuality& quality);

  /// The next sample, with its quality where that has come.
  /// @param wait  for a quality that may still come: then nothing may be returned while samples wait. A quality of
  /// another sample in its place says that it will not come.
  std::optional<OdometrySample> next(bool wait);
  bool waits() const { return !samples_.empty(); }

 private:
  /// Qualities of samples that never come are forgotten beyond this many.
  static constexpr std::size_t kMostQualities = 10000;

  bool willNotCome(Stamp stamp) const;

  std::deque<OdometrySample> samples_;
  std::deque<ratslam_ros::OdometryQuality> qualities_;
};

}  // namespace ratslam
