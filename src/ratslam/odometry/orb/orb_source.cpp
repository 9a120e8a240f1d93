#include "ratslam/odometry/orb/orb_source.h"

#include <stdexcept>
#include <vector>

#include "ratslam/common/state.h"

namespace ratslam {
namespace {

std::vector<double> calibrationOf(const CameraModel& camera) {
  std::vector<double> numbers{static_cast<double>(camera.width),
                              static_cast<double>(camera.height),
                              camera.fx,
                              camera.fy,
                              camera.cx,
                              camera.cy,
                              static_cast<double>(camera.model)};
  numbers.insert(numbers.end(), camera.coefficients.begin(), camera.coefficients.end());
  return numbers;
}

}  // namespace

OrbSource::OrbSource(const CameraModel& camera, const OrbOdometryParams& params)
    : camera_(camera), params_(params) {
  odometry_.emplace(camera, params);
}

OdometrySample OrbSource::track(const ImageFrame& frame) {
  if (frame.begins_anew) odometry_.emplace(camera_, params_);
  result_ = odometry_->track(frame.stamp, frame.image, frame.quality);
  ++frames_;
  if (result_->state == OrbState::kTracking) ++tracked_;
  return result_->sample;
}

std::optional<std::string> OrbSource::failure() const {
  if (frames_ == 0 || tracked_ > 0) return std::nullopt;
  return "none of " + std::to_string(frames_) +
         " images could be tracked by the ORB odometry: no motion is known";
}

void OrbSource::save(State& state) const {
  state.set("camera", calibrationOf(camera_));
  state.set("frames", static_cast<std::uint64_t>(frames_));
  state.set("tracked", static_cast<std::uint64_t>(tracked_));
  state.set("result", result_);
  odometry_->save(state.child("odometry"));
}

void OrbSource::load(const State& state) {
  if (state.get<std::vector<double>>("camera") != calibrationOf(camera_))
    throw std::runtime_error("state " + state.path() + "/camera: it was saved with another calibration");
  OrbOdometry loaded(camera_, params_);
  loaded.load(state.child("odometry"));
  state.get("result", result_);
  frames_ = state.get<std::uint64_t>("frames");
  tracked_ = state.get<std::uint64_t>("tracked");
  odometry_.emplace(std::move(loaded));
}

}  // namespace ratslam
