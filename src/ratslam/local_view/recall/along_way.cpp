#include "ratslam/local_view/recall/along_way.h"

#include <algorithm>

namespace ratslam {

double likestBetween(const LikenessAlong& before, double at, const LikenessAlong& after, double faded) {
  const double behind = -before.distance;
  if (!(behind > 0.0) || !(after.distance > 0.0)) return 0.0;
  // The peak is on the side with more likeness. So the other side gives the fall per metre.
  const double slope = std::max((at - before.likeness) / behind, (at - after.likeness) / after.distance);
  if (!(slope > 0.0) || at - slope * std::max(behind, after.distance) < faded) return 0.0;
  const double peak = (after.likeness - before.likeness + slope * (after.distance - behind)) / (2.0 * slope);
  return std::clamp(peak, -behind / 2.0, after.distance / 2.0);
}

}  // namespace ratslam
