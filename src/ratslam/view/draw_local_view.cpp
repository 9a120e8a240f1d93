#include "ratslam/view/draw_local_view.h"

#include <algorithm>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <string>

#include "ratslam/view/canvas.h"

namespace ratslam {
namespace {

std::string verdict(const ViewEvent& view) {
  if (view.error < 0.0) return view.learned ? ": learned, no candidate" : "";
  char text[64];
  std::snprintf(text, sizeof(text), ": %s, error %.4f", view.learned ? "learned" : "recalled", view.error);
  return text;
}

}  // namespace

cv::Mat drawLocalView(const cv::Mat& image, const ViewEvent& view, const cv::Mat& view_image,
                      const cv::Mat& active_image, const cv::Size& size) {
  constexpr int kTitle = 24;
  constexpr int kGap = 4;
  cv::Mat picture(size, CV_8UC3, kPaper);
  const int half = size.width / 2;
  constexpr double kUsualAspect = 0.3;  // before the first view
  const double aspect =
      view_image.empty() ? kUsualAspect : static_cast<double>(view_image.rows) / view_image.cols;
  const cv::Size panel(half - kGap / 2, std::clamp(cvRound(aspect * half), 1, size.height / 3));
  const int camera_height = size.height - panel.height - kTitle;
  fitInto(toBgr8(image), {size.width, camera_height}, cv::INTER_AREA)
      .copyTo(picture(cv::Rect(0, 0, size.width, camera_height)));
  const int top = camera_height + kTitle;
  const int right = half + kGap / 2;
  if (!view.seen()) {
    label(picture, {0, camera_height + kGap}, "nothing to be seen: no view cell is active");
    return picture;
  }
  fitInto(toBgr8(view_image), panel, cv::INTER_NEAREST).copyTo(picture(cv::Rect({0, top}, panel)));
  fitInto(toBgr8(active_image), panel, cv::INTER_NEAREST).copyTo(picture(cv::Rect({right, top}, panel)));
  label(picture, {0, camera_height + kGap}, "view");
  label(picture, {right, camera_height + kGap}, "template " + std::to_string(view.id) + verdict(view));
  return picture;
}

cv::Mat drawLocalView(const cv::Mat& image, const ViewEvent& view, const LocalViewCells& cells,
                      const cv::Size& size) {
  return drawLocalView(image, view, cells.viewImage(), view.seen() ? cells.templateImage(view.id) : cv::Mat(),
                       size);
}

}  // namespace ratslam
