/// Picture of the local view cells: the camera's image, and under it the present view beside the template of
/// the active view cell, with ids and error.
#pragma once

#include <opencv2/core.hpp>

#include "ratslam/events.h"
#include "ratslam/local_view/local_view_cells.h"

namespace ratslam {

/// @param image         as the camera gave it: 8 or 16 bits, 1, 3 or 4 channels
/// @param view          what the image made of the view cells
/// @param view_image    8-bit mono, one pixel a template value: of the present view
/// @param active_image  the same of the active view cell's template; both unused where none is active
/// @throws std::invalid_argument for an image of another kind
cv::Mat drawLocalView(const cv::Mat& image, const ViewEvent& view, const cv::Mat& view_image,
                      const cv::Mat& active_image, const cv::Size& size);
/// The same after the cells have observed the image. Where recalls are a matter of belief, with the belief
/// over all places below it, oldest at the left, and the places most believed in.
cv::Mat drawLocalView(const cv::Mat& image, const ViewEvent& view, const LocalViewCells& cells,
                      const cv::Size& size);

}  // namespace ratslam
