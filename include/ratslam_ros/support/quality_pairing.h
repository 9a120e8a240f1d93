/// Pairs samples of odometry with their quality, which comes on a separate topic.
///
/// Both topics have one message per sample, in the same order. But either may run ahead of the other, even by more than
/// one lap of a looped recording. So samples and qualities are paired by order and stamp, not by stamp alone.
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

  /// The next sample, with its quality if that has come.
  /// @param wait  whether to wait for a quality that may still come; then the result is none while the sample waits. A
  /// quality of a later sample means that this one will not come.
  std::optional<OdometrySample> next(bool wait);
  bool waits() const { return !samples_.empty(); }

 private:
  /// Bound on qualities whose samples have not come; beyond it the oldest are forgotten.
  static constexpr std::size_t kMostQualities = 10000;

  bool willNotCome(Stamp stamp) const;

  std::deque<OdometrySample> samples_;
  std::deque<ratslam_ros::OdometryQuality> qualities_;
};

}  // namespace ratslam
