#include "ratslam/view/draw_local_view.h"

#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <string>

#include "ratslam/view/canvas.h"

namespace ratslam {
namespace {

std::string verdict(const ViewEvent& view) {
  if (view.error < 0.0) return view.learned ? "no candidate: learned" : "";
  char text[64];
  std::snprintf(text, sizeof(text), "error %.4f: %s", view.error, view.learned ? "learned" : "recalled");
  return text;
}

}  // namespace

cv::Mat drawLocalView(const cv::Mat& image, const ViewEvent& view, const cv::Mat& view_image,
                      const cv::Mat& active_image, const cv::Size& size) {
  cv::Mat picture(size, CV_8UC3, kPaper);
  const int camera_height = size.height * 3 / 5;
  const int half = size.width / 2;
  fitInto(toBgr8(image), {size.width, camera_height}, cv::INTER_AREA)
      .copyTo(picture(cv::Rect(0, 0, size.width, camera_height)));
  const cv::Size panel(half - 2, size.height - camera_height - 4);
  fitInto(toBgr8(view_image), panel, cv::INTER_NEAREST)
      .copyTo(picture(cv::Rect({0, camera_height + 4}, panel)));
  fitInto(toBgr8(active_image), panel, cv::INTER_NEAREST)
      .copyTo(picture(cv::Rect({half + 2, camera_height + 4}, panel)));
  label(picture, {4, camera_height + 8}, "view");
  label(picture, {half + 6, camera_height + 8}, "template " + std::to_string(view.id));
  const std::string result = verdict(view);
  if (!result.empty()) label(picture, {half + 6, size.height - 24}, result);
  return picture;
}

}  // namespace ratslam
