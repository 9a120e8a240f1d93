#include "ratslam_ros/support/odometry_checkpoints.h"

namespace ratslam {

OdometryCheckpoints::OdometryCheckpoints(const NodeParams& params, const ImageStageParams& image_params,
                                         const std::map<std::string, std::string>& parameters,
                                         OdometrySource& source, OdometryPublisher& publisher,
                                         ImageSubscriber& images)
    : longest_gap_(image_params.time_reset),
      source_(source),
      publisher_(publisher),
      images_(images),
      checkpoints_(params, "odometry", parameters) {}

void OdometryCheckpoints::resume() {
  const auto state = checkpoints_.resume();
  if (!state) return;
  source_.load(state->child("source"));
  publisher_.load(state->child("publisher"));
  images_.load(state->child("images"));
  resumed_ = true;
}

ImageFrame OdometryCheckpoints::before(const ImageFrame& frame) {
  checkpoints_.before(frame.stamp, [this](State& state) { save(state); });
  ImageFrame next = frame;
  if (!resumed_) return next;
  resumed_ = false;
  const double gap = secondsBetween(publisher_.lastStamp().value_or(frame.stamp), frame.stamp);
  if (gap > 0.0 && gap <= longest_gap_) return next;
  publisher_.beginAnew();
  next.begins_anew = true;
  return next;
}

void OdometryCheckpoints::finish() {
  checkpoints_.finish([this](State& state) { save(state); });
}

void OdometryCheckpoints::save(State& state) const {
  source_.save(state.child("source"));
  publisher_.save(state.child("publisher"));
  images_.save(state.child("images"));
}

}  // namespace ratslam
