#include "ratslam/system/recall_check.h"

namespace ratslam {

RecallCheck::RecallCheck(const RecallGeometryParams& params, const CameraModel& camera)
    : estimator_(params, camera) {}

ViewEvent RecallCheck::observe(LocalViewCells& cells, Stamp stamp, const View& seen, const cv::Mat& image,
                               const ViewMotion& motion, RecallGeometry& geometry) {
  const ViewEvent view = cells.observe(stamp, seen, image, motion, this);
  estimator_.frame(stamp, image);
  geometry = cells.recallGeometry().value_or(RecallGeometry{});
  geometry.stamp = stamp;
  geometry.view_id = view.id;
  return view;
}

}  // namespace ratslam
