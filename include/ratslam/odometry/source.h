/// Interface of all odometries that are computed from images. Nodes and runner use it for any of them.
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

  /// Motion since the frame before. Each frame gives one sample, whatever its quality; a frozen or blank frame
  /// gives a bridged one.
  /// @throws std::invalid_argument if the source cannot use the image. The source is then unchanged.
  virtual OdometrySample track(const ImageFrame& frame) = 0;

  /// If none of the samples was measured, the reason, which is reported at the end of a run; else none.
  virtual std::optional<std::string> failure() const { return std::nullopt; }

  /// Saves everything that the samples of later frames depend on.
  /// @throws std::runtime_error if the source cannot be saved, or the state is of another source
  virtual void save(State& state) const;
  virtual void load(const State& state);
};

}  // namespace ratslam
