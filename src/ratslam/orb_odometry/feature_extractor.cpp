#include "ratslam/orb_odometry/feature_extractor.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

namespace ratslam {
namespace {

constexpr int kDiscRadius = 15;  // of the intensity centroid [px of the level], as in the ORB paper
constexpr int kBorder = 19;      // the rotated descriptor pattern reaches this far
constexpr int kCellSize = 24;    // of the grid that spreads the corners [px of the level]

/// Direction of the intensity centroid of the disc around a corner [deg].
float centroidAngle(const cv::Mat& image, const cv::Point2f& corner, const std::vector<int>& half_widths) {
  const int x = cvRound(corner.x);
  const int y = cvRound(corner.y);
  int moment_x = 0;
  int moment_y = 0;
  for (int v = -kDiscRadius; v <= kDiscRadius; ++v) {
    const int reach = half_widths[static_cast<std::size_t>(std::abs(v))];
    const uchar* row = image.ptr<uchar>(y + v) + x;
    int sum = 0;
    for (int u = -reach; u <= reach; ++u) {
      sum += row[u];
      moment_x += u * row[u];
    }
    moment_y += v * sum;
  }
  return cv::fastAtan2(static_cast<float>(moment_y), static_cast<float>(moment_x));
}

/// Strongest first; ties in reading order, so that the choice is one.
bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  if (a.response != b.response) return a.response > b.response;
  if (a.pt.y != b.pt.y) return a.pt.y < b.pt.y;
  return a.pt.x < b.pt.x;
}

/// Each cell's strongest corner, then each cell's second, ... until `quota` are taken. Cells are sorted inside.
std::vector<cv::KeyPoint> takeInTurns(std::vector<std::vector<cv::KeyPoint>>& cells, std::size_t quota) {
  for (auto& cell : cells) std::sort(cell.begin(), cell.end(), stronger);
  std::vector<cv::KeyPoint> taken;
  taken.reserve(quota);
  for (std::size_t turn = 0; taken.size() < quota; ++turn) {
    std::vector<cv::KeyPoint> round;
    for (const auto& cell : cells) {
      if (turn < cell.size()) round.push_back(cell[turn]);
    }
    if (round.empty()) break;
    if (taken.size() + round.size() > quota) {
      std::sort(round.begin(), round.end(), stronger);
      round.resize(quota - taken.size());
    }
    taken.insert(taken.end(), round.begin(), round.end());
  }
  return taken;
}

}  // namespace

FeatureExtractor::FeatureExtractor(const ExtractorParams& params) : params_(params) {
  // One level a call: the pyramid is ours, because matches are refined in it to a fraction of a pixel.
  describer_ = cv::ORB::create(1 << 20, 1.2F, 1, kBorder, 0, 2, cv::ORB::HARRIS_SCORE, 31, params.weak_threshold);
  for (int v = 0; v <= kDiscRadius; ++v) {
    row_half_widths_.push_back(static_cast<int>(std::sqrt(kDiscRadius * kDiscRadius - v * v)));
  }
}

std::vector<cv::KeyPoint> FeatureExtractor::cornersOfLevel(const cv::Mat& image, int quota) const {
  const cv::Rect inside(kBorder - 3, kBorder - 3, image.cols - 2 * (kBorder - 3), image.rows - 2 * (kBorder - 3));
  if (inside.width < 7 || inside.height < 7) return {};
  std::vector<cv::KeyPoint> corners;
  cv::FAST(image(inside), corners, params_.weak_threshold, true);

  const int columns = (inside.width + kCellSize - 1) / kCellSize;
  const int rows = (inside.height + kCellSize - 1) / kCellSize;
  std::vector<std::vector<cv::KeyPoint>> cells(static_cast<std::size_t>(columns * rows));
  std::vector<std::vector<cv::KeyPoint>> weak(cells.size());
  for (cv::KeyPoint& corner : corners) {
    const int cell = static_cast<int>(corner.pt.y) / kCellSize * columns + static_cast<int>(corner.pt.x) / kCellSize;
    corner.pt += cv::Point2f(static_cast<float>(inside.x), static_cast<float>(inside.y));
    const bool strong = corner.response >= static_cast<float>(params_.strong_threshold);
    (strong ? cells : weak)[static_cast<std::size_t>(cell)].push_back(corner);
  }
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    if (cells[cell].empty()) cells[cell].swap(weak[cell]);
  }
  return takeInTurns(cells, static_cast<std::size_t>(quota));
}

std::vector<Feature> FeatureExtractor::extract(const ImagePyramid& pyramid, cv::Mat& descriptors) const {
  // A level's share is in proportion to its edge length, so that features per octave fall as slowly as scales do.
  double total = 0.0;
  for (int level = 0; level < pyramid.levels(); ++level) total += 1.0 / pyramid.scale(level);

  std::vector<Feature> features;
  descriptors = cv::Mat(0, 32, CV_8UC1);
  for (int level = 0; level < pyramid.levels(); ++level) {
    const cv::Mat& image = pyramid.image(level);
    const int quota = static_cast<int>(std::lround(params_.features / (total * pyramid.scale(level))));
    std::vector<cv::KeyPoint> corners = cornersOfLevel(image, quota);
    if (corners.empty()) continue;
    for (cv::KeyPoint& corner : corners) {
      corner.angle = centroidAngle(image, corner.pt, row_half_widths_);
      corner.size = 31.0F;
      corner.octave = 0;
    }
    cv::Mat described;
    describer_->compute(image, corners, described);
    descriptors.push_back(described);
    for (const cv::KeyPoint& corner : corners) {
      const Eigen::Vector2d raw = pyramid.fromLevel({corner.pt.x, corner.pt.y}, level);
      features.push_back({raw, raw, corner.angle, level});
    }
  }
  return features;
}

}  // namespace ratslam
