/// Frames in a State. Many parts of an odometry hold the same frame, which is written once and has a number.
///
/// An image is kept as PNG. Features and descriptors are found again when it is read: they depend on nothing
/// else. Their undistorted places are kept, since a lens that was refined step by step leaves its steps there.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "ratslam/vision/frame.h"

namespace ratslam {

class State;

class FramesToSave {
 public:
  /// The frame's number in the State; -1 for none.
  int number(const std::shared_ptr<const Frame>& frame);
  void save(State& state) const;

 private:
  std::map<const Frame*, int> numbers_;
  std::vector<std::shared_ptr<const Frame>> frames_;
};

class LoadedFrames {
 public:
  /// @throws std::runtime_error naming what is missing or does not fit the camera
  LoadedFrames(const State& state, const CameraModel& camera, const FeatureExtractor& extractor,
               const ExtractorParams& params, WorkerPool& workers);
  /// None for -1. @throws std::runtime_error for any other number that no frame has
  std::shared_ptr<Frame> frame(int number) const;

 private:
  std::vector<std::shared_ptr<Frame>> frames_;
};

}  // namespace ratslam
