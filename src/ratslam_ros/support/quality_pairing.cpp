#include "ratslam_ros/support/quality_pairing.h"

#include <algorithm>

#include "ratslam_ros/support/conversions.h"

namespace ratslam {
namespace {

Stamp stampOf(const ratslam_ros::OdometryQuality& quality) { return stampFromRos(quality.header.stamp); }

}  // namespace

void QualityPairing::hearQuality(const ratslam_ros::OdometryQuality& quality) {
  qualities_.push_back(quality);
  if (qualities_.size() > kMostQualities) qualities_.pop_front();
}

std::optional<OdometrySample> QualityPairing::next(bool wait) {
  if (samples_.empty()) return std::nullopt;
  OdometrySample sample = samples_.front();
  const auto own = std::find_if(qualities_.begin(), qualities_.end(),
                                [&](const auto& quality) { return stampOf(quality) == sample.stamp; });
  if (own != qualities_.end()) {
    addQuality(*own, sample);
    qualities_.erase(qualities_.begin(), own + 1);  // the samples of the earlier qualities were lost
  } else if (wait && !willNotCome(sample.stamp)) {
    return std::nullopt;
  }
  samples_.pop_front();
  return sample;
}

/// Whether the first waiting quality is that of a later sample.
bool QualityPairing::willNotCome(Stamp stamp) const {
  if (qualities_.empty()) return false;
  const Stamp first = stampOf(qualities_.front());
  return first > stamp ||
         std::any_of(samples_.begin(), samples_.end(),
                     [first](const OdometrySample& sample) { return sample.stamp == first; });
}

}  // namespace ratslam
