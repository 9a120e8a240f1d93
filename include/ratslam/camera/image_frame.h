/// A decoded image for the models, in order of time, with its quality.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "ratslam/common/stamp.h"

namespace ratslam {

/// Whether an image shows the scene.
enum class ImageQuality : std::uint8_t {
  kUsable = 0,
  kFrozen = 1,  ///< exactly the pixels of the image before: the camera has stopped; the robot may still move
  kBlank = 2,   ///< no texture: darkness, glare, a covered lens
};

/// An image of the stream. From a frozen or blank one nothing is learned, recalled or measured.
struct ImageFrame {
  Stamp stamp = 0;  ///< later than that of the frame before, unless `begins_anew`
  /// CV_8UC1, CV_8UC3 (BGR) or CV_16UC1; of the size of the frame before, unless `begins_anew`.
  cv::Mat image;
  ImageQuality quality = ImageQuality::kUsable;
  /// Time has gone back (a looped recording), or the images have another size: this frame cannot be compared with
  /// earlier ones.
  bool begins_anew = false;

  bool usable() const { return quality == ImageQuality::kUsable; }
};

}  // namespace ratslam
