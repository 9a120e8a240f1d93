#include "ratslam/system/local_view_stage.h"

#include <stdexcept>

namespace ratslam {

LocalViewStage::LocalViewStage(const LocalViewParams& params, const RecallGeometryParams& recall_params)
    : recall_params_(recall_params), cells_(params) {}

void LocalViewStage::setCamera(const CameraModel& camera) {
  if (recall_params_.verifies()) recall_check_ = std::make_unique<RecallCheck>(recall_params_, camera);
}

ViewObservation LocalViewStage::observe(const ImageFrame& frame) {
  if (needsCamera()) throw std::logic_error("recalls are to be verified before the camera is known");
  if (frame.begins_anew) cells_.acceptAnotherSize();
  ViewObservation observation;
  if (recall_check_) {
    observation.geometry.emplace();
    observation.geometry->stamp = frame.stamp;
  }
  if (!frame.usable()) {
    observation.view.stamp = frame.stamp;
    observation.view.id = kNoView;
  } else if (recall_check_) {
    observation.view = recall_check_->observe(cells_, frame.stamp, frame.image, *observation.geometry);
  } else {
    observation.view = cells_.observe(frame.stamp, frame.image);
  }
  if (observation.geometry) observation.geometry->view_id = observation.view.id;
  return observation;
}

}  // namespace ratslam
