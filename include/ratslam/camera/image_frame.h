/// An image as the models get it: decoded, in order of time, and with a word on whether it shows anything.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>

#include "ratslam/common/stamp.h"

namespace ratslam {

/// What an image can tell about the scene.
enum class ImageQuality : std::uint8_t {
  kUsable = 0,
  kFrozen = 1,  ///< exactly the pixels of the image before: the camera has stopped, the robot may not have
  kBlank = 2,   ///< no texture: darkness, glare, a covered lens
};

/// What nothing can be seen in teaches no view, recalls none and measures no motion.
struct ImageFrame {
  Stamp stamp = 0;  ///< later than that of the frame before, unless `begins_anew`
  cv::Mat
      image;  ///< CV_8UC1, CV_8UC3 (BGR) or CV_16UC1; of the size of the frame before, unless `begins_anew`
  ImageQuality quality = ImageQuality::kUsable;
  /// Time has gone back (a looped recording) or the camera has another size: the images before have nothing
  /// to do with this one.
  bool begins_anew = false;

  bool usable() const { return quality == ImageQuality::kUsable; }
};

}  // namespace ratslam
