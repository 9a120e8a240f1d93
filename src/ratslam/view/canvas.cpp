#include "ratslam/view/canvas.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace ratslam {

cv::Mat toBgr8(const cv::Mat& image) {
  const bool deep = image.depth() == CV_16U;
  if (image.empty() || (image.depth() != CV_8U && !deep) || image.channels() == 2 || image.channels() > 4) {
    throw std::invalid_argument("picture: an image of 8 or 16 bits with 1, 3 or 4 channels is needed");
  }
  cv::Mat eight_bits = image;
  if (deep) image.convertTo(eight_bits, CV_8U, 255.0 / 65535.0);
  cv::Mat colours;
  switch (image.channels()) {
    case 1:
      cv::cvtColor(eight_bits, colours, cv::COLOR_GRAY2BGR);
      break;
    case 4:
      cv::cvtColor(eight_bits, colours, cv::COLOR_BGRA2BGR);
      break;
    default:
      colours = eight_bits.clone();
  }
  return colours;
}

cv::Mat fitInto(const cv::Mat& image, const cv::Size& size, int interpolation) {
  cv::Mat picture(size, CV_8UC3, kPaper);
  const double factor =
      std::min(static_cast<double>(size.width) / image.cols, static_cast<double>(size.height) / image.rows);
  const cv::Size scaled(std::clamp(cvRound(factor * image.cols), 1, size.width),
                        std::clamp(cvRound(factor * image.rows), 1, size.height));
  const cv::Rect middle((size.width - scaled.width) / 2, (size.height - scaled.height) / 2, scaled.width,
                        scaled.height);
  cv::resize(image, picture(middle), scaled, 0.0, 0.0, interpolation);
  return picture;
}

void label(cv::Mat& picture, const cv::Point& place, const std::string& text) {
  constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
  constexpr double kSize = 0.45;
  int below = 0;
  const cv::Size extent = cv::getTextSize(text, kFont, kSize, 1, &below);
  const cv::Rect ground(place.x, place.y, extent.width + 8, extent.height + below + 6);
  cv::rectangle(picture, ground, kPaper, cv::FILLED);
  cv::putText(picture, text, {place.x + 4, place.y + extent.height + 3}, kFont, kSize, kInk, 1, cv::LINE_AA);
}

}  // namespace ratslam
