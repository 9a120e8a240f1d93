/// A street seen sideways, and parameters with which its places are told apart.
#pragma once

#include <opencv2/imgproc.hpp>

#include "ratslam/system/pipeline.h"

namespace ratslam {

/// The part of a street of smooth random columns that begins at `offset` [pixels]. @param width  of the whole street
inline cv::Mat streetView(int width, int offset) {
  cv::Mat street(40, width, CV_8UC1);
  cv::RNG random(7);
  random.fill(street, cv::RNG::UNIFORM, 0, 256);
  cv::GaussianBlur(street, street, cv::Size(0, 0), 6.0);
  cv::normalize(street, street, 0, 255, cv::NORM_MINMAX);
  return street.colRange(offset, offset + 160).clone();
}

inline PipelineParams streetParams() {
  PipelineParams p;
  p.local_view.view_template.x_size = 32;
  p.local_view.view_template.y_size = 8;
  p.local_view.match_threshold = 0.02;
  p.local_view.shift_match = 3;
  p.local_view.step_match = 1;
  p.pose_cells.cell_size = 1.0;
  p.pose_cells.experience_distance = 1.0;
  return p;
}

}  // namespace ratslam
