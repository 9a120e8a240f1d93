#include "ratslam/view/draw_features.h"

#include <opencv2/imgproc.hpp>
#include <string>

#include "ratslam/view/canvas.h"

namespace ratslam {

cv::Mat drawFeatures(const cv::Mat& image, const Frame& frame, const CameraModel& camera) {
  const cv::Scalar untracked(200, 140, 60);
  cv::Mat picture = toBgr8(image);
  for (const Feature& feature : frame.features) {
    cv::circle(picture, cv::Point2d(feature.raw.x(), feature.raw.y()), 1, untracked, cv::FILLED);
  }
  for (const Observation& observation : frame.observations) {
    const Eigen::Vector2d raw = camera.distort(observation.pixel);
    cv::circle(picture, cv::Point2d(raw.x(), raw.y()), 3 + observation.level, kRobot, 1, cv::LINE_AA);
  }
  label(picture, {4, 4},
        std::to_string(frame.features.size()) + " features, " + std::to_string(frame.observations.size()) +
            " tracked");
  return picture;
}

}  // namespace ratslam
