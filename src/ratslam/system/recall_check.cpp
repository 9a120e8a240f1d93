#include "ratslam/system/recall_check.h"

namespace ratslam {

RecallCheck::RecallCheck(const RecallGeometryParams& params, const CameraModel& camera)
    : estimator_(params, camera) {}

ViewEvent RecallCheck::observe(LocalViewCells& cells, Stamp stamp, const View& seen, const cv::Mat& image,
                               const ViewMotion& motion) {
  const ViewEvent view = cells.observe(stamp, seen, image, motion, this);
  estimator_.frame(stamp, image);
  return view;
}

}  // namespace ratslam
