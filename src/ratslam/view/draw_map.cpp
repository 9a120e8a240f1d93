#include "ratslam/view/draw_map.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>
#include <string>

#include "ratslam/view/canvas.h"

namespace ratslam {
namespace {

constexpr int kMargin = 24;  // [px]

/// Converts metres of the map to pixels of the picture.
class Projector {
 public:
  Projector(const ExperienceGraph& graph, const MapPose& robot, const cv::Size& size) : size_(size) {
    double left = robot.x;
    double right = robot.x;
    double bottom = robot.y;
    double top = robot.y;
    for (const Experience& experience : graph.experiences()) {
      left = std::min(left, experience.pose.x);
      right = std::max(right, experience.pose.x);
      bottom = std::min(bottom, experience.pose.y);
      top = std::max(top, experience.pose.y);
    }
    centre_ = {(left + right) / 2.0, (bottom + top) / 2.0};
    const double width = std::max(right - left, 1e-3);
    const double height = std::max(top - bottom, 1e-3);
    per_metre_ = std::min((size.width - 2 * kMargin) / width, (size.height - 2 * kMargin) / height);
  }

  double perMetre() const { return per_metre_; }
  cv::Point2d operator()(double x, double y) const {
    return {size_.width / 2.0 + per_metre_ * (x - centre_.x),
            size_.height / 2.0 - per_metre_ * (y - centre_.y)};
  }
  cv::Point2d operator()(const MapPose& pose) const { return (*this)(pose.x, pose.y); }

 private:
  cv::Size size_;
  cv::Point2d centre_;
  double per_metre_ = 1.0;
};

/// A position in fractions of a pixel. Many links are hardly longer than a pixel and would look like beads if rounded.
constexpr int kFineBits = 4;
cv::Point fine(const cv::Point2d& place) {
  return {cvRound(place.x * (1 << kFineBits)), cvRound(place.y * (1 << kFineBits))};
}

/// Draws a link. A link shorter than a pixel is drawn as a dot: large maps have a hundred thousand of them, and lines would
/// take too long.
void drawLink(cv::Mat& picture, const cv::Point2d& from, const cv::Point2d& to, const cv::Scalar& colour) {
  if (std::max(std::abs(to.x - from.x), std::abs(to.y - from.y)) >= 1.0) {
    cv::line(picture, fine(from), fine(to), colour, 2, cv::LINE_AA, kFineBits);
    return;
  }
  const cv::Rect dot(cvFloor(to.x), cvFloor(to.y), 2, 2);
  picture(dot & cv::Rect({}, picture.size())).setTo(colour);
}

/// Draws a scale bar of 1, 2 or 5 times a power of ten metres, at most a quarter of the picture wide.
void drawScale(cv::Mat& picture, double per_metre) {
  const double longest = picture.cols / 4.0 / per_metre;
  const double power = std::pow(10.0, std::floor(std::log10(longest)));
  const double length = longest >= 5.0 * power ? 5.0 * power : longest >= 2.0 * power ? 2.0 * power : power;
  const cv::Point begin(kMargin, picture.rows - 12);
  cv::line(picture, begin, {begin.x + cvRound(length * per_metre), begin.y}, kInk, 2);
  char text[32];
  std::snprintf(text, sizeof(text), "%g m", length);
  label(picture, {begin.x, begin.y - 20}, text);
}

void drawRobot(cv::Mat& picture, const cv::Point2d& place, double yaw) {
  const auto corner = [&](double angle, double length) {
    return cv::Point(cvRound(place.x + length * std::cos(yaw + angle)),
                     cvRound(place.y - length * std::sin(yaw + angle)));
  };
  const std::vector<cv::Point> arrow{corner(0.0, 12.0), corner(2.5, 9.0), corner(kPi, 4.0),
                                     corner(-2.5, 9.0)};
  cv::fillPoly(picture, std::vector<std::vector<cv::Point>>{arrow}, kRobot, cv::LINE_AA);
}

}  // namespace

cv::Mat drawMap(const ExperienceGraph& graph, const MapPose& robot, const cv::Size& size) {
  cv::Mat picture(size, CV_8UC3, kPaper);
  const Projector project(graph, robot, size);
  std::size_t recalls = 0;
  for (const bool recall : {false, true}) {  // links by recall are drawn on top
    for (const Link& link : graph.links()) {
      if (link.recall != recall) continue;
      recalls += recall ? 1 : 0;
      drawLink(picture, project(graph.pose(link.from)), project(graph.pose(link.to)),
               recall ? kRecallLink : kDrivenLink);
    }
  }
  drawRobot(picture, project(robot), robot.yaw);
  drawScale(picture, project.perMetre());
  label(picture, {4, 4},
        std::to_string(graph.experiences().size()) + " experiences, " + std::to_string(recalls) +
            " links by recall");
  return picture;
}

}  // namespace ratslam
