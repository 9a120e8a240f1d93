#include "ratslam/local_view/orientation/orientation_picture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "ratslam/common/angles.h"
#include "ratslam/local_view/orientation/orientation_energy.h"

namespace ratslam {
namespace {

constexpr int kCellPixels = 20;
constexpr double kStroke = 0.42 * kCellPixels;  // half its length
constexpr int kUsual = 24;                      // edges up to this strength are not drawn [levels]
constexpr int kGround = 24;                     // grey value of the background

}  // namespace

cv::Mat orientationPicture(const std::vector<std::int8_t>& values) {
  cv::Mat picture(kOrientationCellRows * kCellPixels, kOrientationCellColumns * kCellPixels, CV_8UC1,
                  cv::Scalar(kGround));
  constexpr int kSubpixelBits = 4;
  const auto at = [](double pixels) { return cvRound(pixels * (1 << kSubpixelBits)); };
  for (int cell = 0; cell < kOrientationCellRows * kOrientationCellColumns; ++cell) {
    const int row = cell / kOrientationCellColumns;
    const double x = (cell % kOrientationCellColumns + 0.5) * kCellPixels;
    const double y = (row + 0.5) * kCellPixels;
    std::vector<std::pair<int, int>> strokes;  // strength and bin, the weakest first
    for (int bin = 0; bin < kOrientationBins; ++bin) {
      const std::int8_t strength = values[static_cast<std::size_t>(cell * kOrientationBins + bin)];
      if (strength > kUsual) strokes.emplace_back(strength, bin);
    }
    std::sort(strokes.begin(), strokes.end());
    for (const auto& [strength, bin] : strokes) {
      const double edge = kPi * bin / kOrientationBins + 0.5 * kPi;  // across the gradient
      const double dx = kStroke * std::cos(edge);
      const double dy = kStroke * std::sin(edge);
      cv::line(picture, {at(x - dx), at(y - dy)}, {at(x + dx), at(y + dy)},
               cv::Scalar(std::min(255, kGround + 2 * strength)), 1, cv::LINE_AA, kSubpixelBits);
    }
  }
  return picture;
}

}  // namespace ratslam
