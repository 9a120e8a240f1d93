#include "ratslam/odometry/orb/orb_source.h"

#include <sstream>
#include <stdexcept>
#include <string>
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

std::string listed(const std::vector<double>& numbers) {
  std::ostringstream text;
  for (const double number : numbers) text << ' ' << number;
  return text.str();
}

/// @throws std::runtime_error with both calibrations if the saved one is another
void requireCalibration(const State& state, const CameraModel& camera) {
  const auto saved = state.get<std::vector<double>>("camera");
  const std::vector<double> given = calibrationOf(camera);
  if (saved == given) return;
  throw std::runtime_error(
      "the odometry was saved with another calibration: width, height, fx, fy, cx, cy, model, "
      "coefficients were" +
      listed(saved) + ", now they are" + listed(given));
}

}  // namespace

OrbSource::OrbSource(const CameraModel& camera, const OrbOdometryParams& params)
    : camera_(camera), params_(params) {
  odometry_.emplace(camera, params);
}

OdometrySample OrbSource::track(const ImageFrame& frame) {
  if (frame.begins_anew) {
    OrbOdometry anew(camera_, params_);
    anew.continueAt(*odometry_);  // REP-105: the odometry's frame is continuous
    odometry_.emplace(std::move(anew));
  }
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
  requireCalibration(state, camera_);
  OrbOdometry loaded(camera_, params_);
  loaded.load(state.child("odometry"));
  state.get("result", result_);
  frames_ = state.get<std::uint64_t>("frames");
  tracked_ = state.get<std::uint64_t>("tracked");
  odometry_.emplace(std::move(loaded));
}

}  // namespace ratslam
