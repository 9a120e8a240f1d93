/// Frames in a State. Several parts of an odometry share a frame. It is written once, under a number.
///
/// An image is saved as PNG. Features and descriptors depend only on the image, so they are extracted again on
/// reading. Their undistorted positions are saved, because they depend on the steps of the lens refinement.
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
  /// The frame of a number; null for -1. @throws std::runtime_error for any other number without a frame
  std::shared_ptr<Frame> frame(int number) const;

 private:
  std::vector<std::shared_ptr<Frame>> frames_;
};

}  // namespace ratslam
