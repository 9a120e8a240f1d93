/// Picture of the pose cells: activity summed along each of the three axes of the network, and the trail of the best
/// estimate (Malichev & Yakhno 2024, Fig. 4).
///
/// The plane (x to the right, y up) is at the upper left, heading over x below it, heading over y to its right. Each is a
/// square. The fourth corner shows the estimate in numbers [cells, degrees].
#pragma once

#include <deque>
#include <opencv2/core.hpp>

#include "ratslam/pose_cells/activity_grid.h"

namespace ratslam {

/// The last estimates, newest last, at most kTrailLength.
class ActivityTrail {
 public:
  static constexpr std::size_t kTrailLength = 200;
  void add(const PoseCellEstimate& estimate);
  const std::deque<PoseCellEstimate>& estimates() const { return estimates_; }

 private:
  std::deque<PoseCellEstimate> estimates_;
};

cv::Mat drawActivity(const ActivityGrid& activity, const ActivityTrail& trail, const cv::Size& size);

}  // namespace ratslam
