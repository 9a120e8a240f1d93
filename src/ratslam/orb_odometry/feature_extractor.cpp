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

/// Each cell's strongest corner, then each cell's second, ... until `quota` are taken. Cells are sorted
/// inside.
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
  describer_ =
      cv::ORB::create(1 << 20, 1.2F, 1, kBorder, 0, 2, cv::ORB::HARRIS_SCORE, 31, params.weak_threshold);
  for (int v = 0; v <= kDiscRadius; ++v) {
    row_half_widths_.push_back(static_cast<int>(std::sqrt(kDiscRadius * kDiscRadius - v * v)));
  }
}

std::vector<cv::KeyPoint> FeatureExtractor::cornersOfLevel(const cv::Mat& image, int quota) const {
  constexpr int kReach = 3;  // FAST looks this far around a pixel
  const cv::Rect inside(kBorder, kBorder, image.cols - 2 * kBorder, image.rows - 2 * kBorder);
  if (inside.width < 1 || inside.height < 1) return {};
  const int columns = (inside.width + kCellSize - 1) / kCellSize;
  const int rows = (inside.height + kCellSize - 1) / kCellSize;
  std::vector<std::vector<cv::KeyPoint>> cells(static_cast<std::size_t>(columns * rows));

  const auto detect = [&](const cv::Rect& area, int threshold) {
    const cv::Rect with_rim(area.x - kReach, area.y - kReach, area.width + 2 * kReach,
                            area.height + 2 * kReach);
    std::vector<cv::KeyPoint> corners;
    cv::FAST(image(with_rim), corners, threshold, true);
    for (cv::KeyPoint& corner : corners) {
      corner.pt += cv::Point2f(static_cast<float>(with_rim.x), static_cast<float>(with_rim.y));
      const int column = (static_cast<int>(corner.pt.x) - inside.x) / kCellSize;
      const int row = (static_cast<int>(corner.pt.y) - inside.y) / kCellSize;
      cells[static_cast<std::size_t>(row * columns + column)].push_back(corner);
    }
  };
  detect(inside, params_.strong_threshold);
  // The low threshold is costly where there is texture, and needed only where there is none: one call for
  // each run of empty cells.
  std::vector<bool> empty;
  empty.reserve(cells.size());
  for (const auto& cell : cells) empty.push_back(cell.empty());
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int begin = column;
      while (column < columns && empty[static_cast<std::size_t>(row * columns + column)]) ++column;
      if (column == begin) continue;
      const cv::Rect run(inside.x + begin * kCellSize, inside.y + row * kCellSize,
                         (column - begin) * kCellSize, kCellSize);
      detect(run & inside, params_.weak_threshold);
    }
  }
  return takeInTurns(cells, static_cast<std::size_t>(quota));
}

std::vector<Feature> FeatureExtractor::extract(const ImagePyramid& pyramid, cv::Mat& descriptors) const {
  // A level's share is in proportion to its edge length, so that features per octave fall as slowly as scales
  // do.
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
