#include "ratslam/experience_map/trajectory.h"

namespace ratslam {

void Trajectory::record(Stamp stamp, std::uint32_t frame, const RelativePose& relative,
                        const MapPose& online) {
  if (!samples_.empty() && samples_.back().stamp == stamp) {
    samples_.back() = {stamp, frame, relative};
    online_.back() = {stamp, online};
    return;
  }
  samples_.push_back({stamp, frame, relative});
  online_.push_back({stamp, online});
}

void Trajectory::rebase(const MapPose& origin, const MapPose& first) {
  for (Sample& sample : samples_) sample.relative = between(first, compose(origin, sample.relative));
}

}  // namespace ratslam
