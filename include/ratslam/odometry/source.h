/// What every odometry made of images offers, so that nodes and runner need not know which one it is.
#pragma once

#include <optional>
#include <string>

#include "ratslam/camera/image_frame.h"
#include "ratslam/odometry/odometry.h"

namespace ratslam {

class State;

class OdometrySource {
 public:
  OdometrySource() = default;
  OdometrySource(const OdometrySource&) = delete;
  OdometrySource& operator=(const OdometrySource&) = delete;
  virtual ~OdometrySource() = default;

  /// Motion since the frame before, one sample a frame whatever its quality: a frame that shows nothing gives
  /// a bridged one.
  /// @throws std::invalid_argument where the image does not suit the source; it is then as before
  virtual OdometrySample track(const ImageFrame& frame) = 0;

  /// Why nothing of all it gave was measured, where that is so: said at the end of a run.
  virtual std::optional<std::string> failure() const { return std::nullopt; }

  /// All that the samples of later frames depend on.
  /// @throws std::runtime_error where the source cannot be saved, or the state is of another source
  virtual void save(State& state) const;
  virtual void load(const State& state);
};

}  // namespace ratslam
