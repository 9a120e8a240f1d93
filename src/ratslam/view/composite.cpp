#include "ratslam/view/composite.h"

#include <opencv2/imgproc.hpp>

#include "ratslam/view/canvas.h"

namespace ratslam {
namespace {

constexpr int kLeftWidth = kCompositeWidth / 2;
constexpr int kUpperHeight = kCompositeHeight * 2 / 5;

void put(cv::Mat& picture, const cv::Mat& part, const cv::Rect& place) {
  if (part.empty()) return;
  (part.size() == place.size() ? part : fitInto(part, place.size(), cv::INTER_AREA)).copyTo(picture(place));
}

}  // namespace

cv::Size localViewPictureSize() { return {kLeftWidth, kUpperHeight}; }
cv::Size activityPictureSize() { return {kLeftWidth, kCompositeHeight - kUpperHeight}; }
cv::Size mapPictureSize() { return {kCompositeWidth - kLeftWidth, kCompositeHeight}; }

cv::Mat composite(const cv::Mat& local_view, const cv::Mat& activity, const cv::Mat& map) {
  cv::Mat picture(kCompositeHeight, kCompositeWidth, CV_8UC3, kPaper);
  put(picture, local_view, {{0, 0}, localViewPictureSize()});
  put(picture, activity, {{0, kUpperHeight}, activityPictureSize()});
  put(picture, map, {{kLeftWidth, 0}, mapPictureSize()});
  return picture;
}

}  // namespace ratslam
