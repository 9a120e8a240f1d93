#include "ratslam/system/recall_check.h"

namespace ratslam {
namespace {

RecallCamera recallCamera(const CameraModel& camera) {
  camera.validate();
  RecallCamera result;
  result.fx = camera.fx;
  result.fy = camera.fy;
  result.cx = camera.cx;
  result.cy = camera.cy;
  if (camera.model != LensModel::kNone) {
    result.undistort = [camera](const std::vector<Eigen::Vector2d>& raw) { return camera.undistort(raw); };
  }
  return result;
}

}  // namespace

RecallCheck::RecallCheck(const RecallGeometryParams& params, const CameraModel& camera)
    : estimator_(params, recallCamera(camera)) {}

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
