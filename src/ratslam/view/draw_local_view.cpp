#include "ratslam/view/draw_local_view.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "ratslam/view/canvas.h"

namespace ratslam {
namespace {

std::string verdict(const ViewEvent& view) {
  if (view.error < 0.0) return view.learned ? ": learned, no candidate" : "";
  char text[64];
  std::snprintf(text, sizeof(text), ": %s, error %.4f", view.learned ? "learned" : "recalled", view.error);
  return text;
}

constexpr int kTitle = 24;
constexpr int kGap = 4;
constexpr int kBeliefHeight = 56;
constexpr std::size_t kCandidates = 3;
constexpr std::size_t kDrawnPlaces = 4096;  // number of most likely places that are drawn
constexpr double kFaintest = 1e-6;          // belief at the bottom of the logarithmic scale

/// Draws the belief over places from the oldest at the left to the newest at the right, on a logarithmic scale.
void drawBelief(cv::Mat panel, const LocalViewCells& cells, const ViewEvent& view) {
  const double places = static_cast<double>(std::max<std::size_t>(cells.size(), 1));
  const auto column = [&](std::uint32_t place) {
    return static_cast<int>(place * static_cast<double>(panel.cols - 1) / places);
  };
  const auto height = [&](double mass) {
    const double share = 1.0 - std::log(std::max(mass, kFaintest)) / std::log(kFaintest);
    return cvRound(share * (panel.rows - 1));
  };
  panel.setTo(cv::Scalar(48, 42, 38));
  const auto bar = [&](std::uint32_t place, double mass, const cv::Scalar& colour) {
    const int x = column(place);
    cv::line(panel, {x, panel.rows - 1}, {x, panel.rows - 1 - height(mass)}, colour);
  };
  std::vector<PlaceMass> places_by_mass = cells.belief().strongest(kDrawnPlaces);
  for (auto it = places_by_mass.rbegin(); it != places_by_mass.rend(); ++it)
    bar(it->place, it->mass, kDrivenLink);
  for (std::size_t i = 0; i < std::min(kCandidates, places_by_mass.size()); ++i) {
    bar(places_by_mass[i].place, places_by_mass[i].mass, kRecallLink);
  }
  if (view.seen()) cv::circle(panel, {column(view.id), panel.rows - 4}, 3, kRobot, cv::FILLED, cv::LINE_AA);
}

std::string candidates(const LocalViewCells& cells) {
  char text[64];
  std::snprintf(text, sizeof(text), "belief: not yet known %.3f", cells.belief().unknown());
  std::string line = text;
  for (const PlaceMass& place : cells.belief().strongest(kCandidates)) {
    std::snprintf(text, sizeof(text), ", %u: %.3f", place.place, place.mass);
    line += text;
  }
  return line;
}

}  // namespace

cv::Mat drawLocalView(const cv::Mat& image, const ViewEvent& view, const cv::Mat& view_image,
                      const cv::Mat& active_image, const cv::Size& size) {
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
  // Blocks must stay sharp when enlarged, strokes smooth when reduced.
  const int interpolation = view_image.cols < panel.width ? cv::INTER_NEAREST : cv::INTER_AREA;
  fitInto(toBgr8(view_image), panel, interpolation).copyTo(picture(cv::Rect({0, top}, panel)));
  fitInto(toBgr8(active_image), panel, interpolation).copyTo(picture(cv::Rect({right, top}, panel)));
  label(picture, {0, camera_height + kGap}, "view");
  label(picture, {right, camera_height + kGap}, "template " + std::to_string(view.id) + verdict(view));
  return picture;
}

cv::Mat drawLocalView(const cv::Mat& image, const ViewEvent& view, const LocalViewCells& cells,
                      const cv::Size& size) {
  const cv::Mat active = view.seen() ? cells.templateImage(view.id) : cv::Mat();
  if (!cells.params().recall.believes()) return drawLocalView(image, view, cells.viewImage(), active, size);
  const int views_height = size.height - kBeliefHeight - kTitle;
  cv::Mat picture(size, CV_8UC3, kPaper);
  drawLocalView(image, view, cells.viewImage(), active, {size.width, views_height})
      .copyTo(picture(cv::Rect(0, 0, size.width, views_height)));
  drawBelief(picture(cv::Rect(0, views_height + kTitle, size.width, kBeliefHeight)), cells, view);
  label(picture, {0, views_height + kGap}, candidates(cells));
  return picture;
}

}  // namespace ratslam
