/// Images and parameters that the tests of the local view share.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>
#include <vector>

#include "ratslam/local_view/local_view_params.h"

namespace ratslam {

inline std::filesystem::path dataFolder() {
  const char* configured = std::getenv("RATSLAM_DATA");
  return configured != nullptr ? std::filesystem::path(configured)
                               : std::filesystem::path(RATSLAM_SOURCE_DIR "/../shared/data");
}

inline cv::Mat kittiImage(int frame) {
  char name[16];
  std::snprintf(name, sizeof name, "%06d.jpg", frame);
  return cv::imread((dataFolder() / "kitti_00/image_0" / name).string(), cv::IMREAD_GRAYSCALE);
}

inline LocalViewParams smallParams(int columns, int rows, int shift, int step, bool panoramic) {
  LocalViewParams params;
  params.view_template.x_size = columns;
  params.view_template.y_size = rows;
  params.shift_match = shift;
  params.step_match = step;
  params.panoramic = panoramic;
  params.match_threshold = 0.2;
  return params;
}

/// Values of a template, evenly distributed.
inline std::vector<double> randomValues(const LocalViewParams& params, std::mt19937& random) {
  std::uniform_real_distribution<double> value(0.0, 1.0);
  std::vector<double> values(
      static_cast<std::size_t>(params.view_template.x_size * params.view_template.y_size));
  for (double& v : values) v = value(random);
  return values;
}

/// Parameters of openratslam_reference/local_view_forward.csv.
inline LocalViewParams forwardReference() {
  LocalViewParams params;
  params.view_template.crop_x_max = 1241;
  params.view_template.crop_y_min = 60;
  params.view_template.crop_y_max = 300;
  params.view_template.x_size = 60;
  params.view_template.y_size = 10;
  params.view_template.normalisation = 0.4;
  params.match_threshold = 0.04;
  params.shift_match = 5;
  params.step_match = 1;
  return params;
}

/// Parameters of openratslam_reference/local_view_panoramic.csv.
inline LocalViewParams panoramicReference() {
  LocalViewParams params = forwardReference();
  params.view_template.normalisation = 0.0;
  params.view_template.patch_radius = 2;
  params.match_threshold = 0.09;
  params.step_match = 5;
  params.panoramic = true;
  return params;
}

}  // namespace ratslam
