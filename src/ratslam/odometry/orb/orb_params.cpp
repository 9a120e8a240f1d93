#include "ratslam/odometry/orb/orb_params.h"

namespace ratslam {

void OrbOdometryParams::validate() const {
  checkBounds(*this);
  if (fast_min_threshold > fast_threshold) {
    throwBadValue("orb_fast_min_threshold", fast_min_threshold, "it must not exceed orb_fast_threshold");
  }
  if (map_keyframes <= window_keyframes) {
    throwBadValue("orb_map_keyframes", map_keyframes, "it must exceed orb_window_keyframes");
  }
}

}  // namespace ratslam
