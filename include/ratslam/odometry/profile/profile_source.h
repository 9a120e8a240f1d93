/// The intensity profiles (profile_odometry.h) as a source of odometry.
#pragma once

#include "ratslam/odometry/profile/profile_odometry.h"
#include "ratslam/odometry/source.h"

namespace ratslam {

class ProfileSource : public OdometrySource {
 public:
  using Params = ProfileOdometryParams;

  /// @throws std::invalid_argument for bad parameters
  explicit ProfileSource(const ProfileOdometryParams& params) : odometry_(params) {}

  OdometrySample track(const ImageFrame& frame) override {
    if (frame.begins_anew) odometry_.restart();
    return frame.usable() ? odometry_.track(frame.stamp, frame.image) : odometry_.bridge(frame.stamp);
  }

  void save(State& state) const override { odometry_.save(state); }
  void load(const State& state) override { odometry_.load(state); }

 private:
  ProfileOdometry odometry_;
};

}  // namespace ratslam
