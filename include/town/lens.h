/// The lens of a camera with plumb-bob distortion (Brown 1966, as OpenCV writes it), inverted.
#pragma once

#include <opencv2/core.hpp>

#include "town/camera.h"

namespace ratslam {

/// Conversion of the picture of an ideal camera to that of a distorted one.
struct LensMap {
  TownCamera ideal;      ///< a pinhole that sees everything the distorted camera sees
  cv::Mat map_x, map_y;  ///< CV_32F, position in the ideal picture for each pixel; empty without distortion
};

/// @throws std::invalid_argument if the distortion cannot be inverted everywhere in the picture.
LensMap makeLensMap(const TownCamera& camera);

}  // namespace ratslam
