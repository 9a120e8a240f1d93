#include "ratslam/experience_map/trajectory.h"

namespace ratslam {

void Trajectory::record(Stamp stamp, std::uint32_t frame, const RelativePose& relative, const MapPose& online,
                        const Eigen::Quaterniond& tilt) {
  if (!samples_.empty() && samples_.back().stamp == stamp) {
    samples_.back() = {stamp, frame, relative, tilt};
    online_.back() = {stamp, online, tilt};
    return;
  }
  samples_.push_back({stamp, frame, relative, tilt});
  online_.push_back({stamp, online, tilt});
}

std::optional<std::size_t> Trajectory::indexAt(Stamp stamp) const {
  for (std::size_t k = samples_.size(); k-- > 0;) {
    if (samples_[k].stamp <= stamp) return k;
    if (k > 0 && samples_[k - 1].stamp > samples_[k].stamp) return std::nullopt;
  }
  return std::nullopt;
}

void Trajectory::rebase(const MapPose& origin, const MapPose& first) {
  for (Sample& sample : samples_) sample.relative = between(first, compose(origin, sample.relative));
}

}  // namespace ratslam
