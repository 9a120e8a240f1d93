/// Whether an image shows anything new to see: a camera that hangs gives the same image again, a covered or
/// dazzled one gives none.
#pragma once

#include <opencv2/core.hpp>

namespace ratslam {

enum class Sight {
  kClear,
  kFrozen,  ///< every pixel equals that of the image before
  kBlank,   ///< no texture
};

class ImageSight {
 public:
  /// @param grey 8-bit, one channel.
  Sight look(const cv::Mat& grey);

 private:
  cv::Mat last_;
};

}  // namespace ratslam
