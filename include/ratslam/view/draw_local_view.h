/// Picture of the local view cells: the camera's image, and below it the present view and the template of the active view
/// cell, with ids and error.
#pragma once

#include <opencv2/core.hpp>

#include "ratslam/events.h"
#include "ratslam/local_view/local_view_cells.h"

namespace ratslam {

/// @param image         camera's image: 8 or 16 bits, 1, 3 or 4 channels
/// @param view          view event of the image
/// @param view_image    the present view: 8-bit mono, one pixel per template value
/// @param active_image  the same for the active view cell's template; both are unused if no cell is active
/// @throws std::invalid_argument for an image of another kind
cv::Mat drawLocalView(const cv::Mat& image, const ViewEvent& view, const cv::Mat& view_image,
                      const cv::Mat& active_image, const cv::Size& size);
/// The same after the cells have observed the image. With vt_recall belief it also shows the belief over all places, from
/// the oldest at the left, and the most likely places.
cv::Mat drawLocalView(const cv::Mat& image, const ViewEvent& view, const LocalViewCells& cells,
                      const cv::Size& size);

}  // namespace ratslam
