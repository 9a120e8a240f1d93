#include "ratslam/view/draw_activity.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <string>

#include "ratslam/view/canvas.h"

namespace ratslam {
namespace {

/// One of the three projections: the sums, and the coordinates of an estimate in them.
struct Projection {
  cv::Mat sums;  ///< CV_64F, row 0 at the bottom of the picture
  double PoseCellEstimate::*across;
  double PoseCellEstimate::*up;
  std::string name;
};

cv::Mat coloured(const cv::Mat& sums) {
  double largest = 0.0;
  cv::minMaxLoc(sums, nullptr, &largest);
  cv::Mat roots;
  cv::sqrt(largest > 0.0 ? cv::Mat(sums / largest) : sums,
           roots);  // on a linear scale only the peak would show
  cv::Mat grey;
  roots.convertTo(grey, CV_8U, 255.0);
  cv::flip(grey, grey, 0);
  cv::Mat colours;
  cv::applyColorMap(grey, colours, cv::COLORMAP_INFERNO);
  return colours;
}

/// Draws the trail into a picture of the projection. Steps across the edge of the torus are not joined.
void drawTrail(cv::Mat& picture, const Projection& projection, const ActivityTrail& trail) {
  const double cell_width = static_cast<double>(picture.cols) / projection.sums.cols;
  const double cell_height = static_cast<double>(picture.rows) / projection.sums.rows;
  const auto place = [&](const PoseCellEstimate& estimate) {
    // Coordinate 0 is the middle of cell 0.
    const double across = std::fmod(estimate.*projection.across + 0.5, projection.sums.cols);
    const double up = std::fmod(estimate.*projection.up + 0.5, projection.sums.rows);
    return cv::Point2d(across * cell_width, picture.rows - up * cell_height);
  };
  const auto& estimates = trail.estimates();
  for (std::size_t i = 1; i < estimates.size(); ++i) {
    const cv::Point2d from = place(estimates[i - 1]);
    const cv::Point2d to = place(estimates[i]);
    const bool wraps =
        std::abs(to.x - from.x) > picture.cols / 2.0 || std::abs(to.y - from.y) > picture.rows / 2.0;
    if (!wraps) cv::line(picture, from, to, kRobot, 2, cv::LINE_AA);
  }
  if (!estimates.empty()) cv::circle(picture, place(estimates.back()), 4, kRobot, 2, cv::LINE_AA);
}

std::vector<Projection> projectionsOf(const ActivityGrid& activity) {
  const int n = activity.nXy();
  const int layers = activity.nTh();
  cv::Mat plane = cv::Mat::zeros(n, n, CV_64F);
  cv::Mat heading_x = cv::Mat::zeros(layers, n, CV_64F);
  cv::Mat heading_y = cv::Mat::zeros(n, layers, CV_64F);
  for (int layer = 0; layer < layers; ++layer) {
    for (int row = 0; row < n; ++row) {
      const double* cells = activity.data() + activity.offset(layer, row);
      for (int column = 0; column < n; ++column) {
        plane.at<double>(row, column) += cells[column];
        heading_x.at<double>(layer, column) += cells[column];
        heading_y.at<double>(row, layer) += cells[column];
      }
    }
  }
  return {{plane, &PoseCellEstimate::x, &PoseCellEstimate::y, "y over x"},
          {heading_y, &PoseCellEstimate::th, &PoseCellEstimate::y, "y over heading"},
          {heading_x, &PoseCellEstimate::x, &PoseCellEstimate::th, "heading over x"}};
}

}  // namespace

void ActivityTrail::add(const PoseCellEstimate& estimate) {
  estimates_.push_back(estimate);
  if (estimates_.size() > kTrailLength) estimates_.pop_front();
}

cv::Mat drawActivity(const ActivityGrid& activity, const ActivityTrail& trail, const cv::Size& size) {
  constexpr int kGap = 4;
  cv::Mat picture(size, CV_8UC3, kPaper);
  const int side = std::max((std::min(size.width, size.height) - kGap) / 2, 1);
  const cv::Size panel(side, side);
  const cv::Point corner((size.width - 2 * side - kGap) / 2, (size.height - 2 * side - kGap) / 2);
  const cv::Point places[3] = {corner, corner + cv::Point(side + kGap, 0),
                               corner + cv::Point(0, side + kGap)};
  const std::vector<Projection> projections = projectionsOf(activity);
  for (std::size_t i = 0; i < projections.size(); ++i) {
    cv::Mat part;
    cv::resize(coloured(projections[i].sums), part, panel, 0.0, 0.0, cv::INTER_NEAREST);
    drawTrail(part, projections[i], trail);
    label(part, {4, 4}, projections[i].name);
    part.copyTo(picture(cv::Rect(places[i], panel)));
  }
  if (!trail.estimates().empty()) {
    const PoseCellEstimate& now = trail.estimates().back();
    char text[64];
    std::snprintf(text, sizeof(text), "x %.1f  y %.1f  %.0f deg", now.x, now.y,
                  360.0 * now.th / activity.nTh());
    label(picture, corner + cv::Point(side + kGap + 4, side + kGap + 4), text);
  }
  return picture;
}

}  // namespace ratslam
