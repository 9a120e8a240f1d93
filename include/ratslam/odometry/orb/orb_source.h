/// The ORB odometry (orb_odometry.h) as a source of odometry.
#pragma once

#include <optional>

#include "ratslam/odometry/orb/orb_odometry.h"
#include "ratslam/odometry/source.h"

namespace ratslam {

class OrbSource : public OdometrySource {
 public:
  using Params = OrbOdometryParams;

  /// @throws std::invalid_argument for an invalid camera or invalid parameters
  OrbSource(const CameraModel& camera, const OrbOdometryParams& params);

  OdometrySample track(const ImageFrame& frame) override;
  std::optional<std::string> failure() const override;
  void save(State& state) const override;
  void load(const State& state) override;

  const OrbOdometry& odometry() const { return *odometry_; }
  /// Full result of the last frame; none before the first.
  const std::optional<OrbResult>& result() const { return result_; }
  /// The calibration given to the constructor.
  const CameraModel& camera() const { return camera_; }

 private:
  CameraModel camera_;
  OrbOdometryParams params_;
  std::optional<OrbOdometry> odometry_;
  std::optional<OrbResult> result_;
  std::size_t frames_ = 0;
  std::size_t tracked_ = 0;
};

}  // namespace ratslam
