#include "ratslam/vision/recall_features.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <tuple>

#include "ratslam/common/params.h"
#include "ratslam/simd/feature_kernels.h"

namespace ratslam {
namespace {

constexpr double kScaleFactor = 1.25;  // between pyramid levels
constexpr int kLevels = 6;
constexpr int kBorder = 22;           // a turned descriptor reaches so far [px]
constexpr int kFastThreshold = 10;    // [grey levels]
constexpr int kFeaturesPerCell = 4;   // mean over the grid
constexpr double kMaxPixels = 800e3;  // larger images are shrunk
constexpr int kMaxDistance = 64;      // of a match [bits]
constexpr double kMaxRatio = 0.85;    // of best to second-best distance
constexpr float kSameCorner = 8.0F;   // nearer than this, in sigmas, two features may be one corner
constexpr double kCornerSigma = 0.4;  // of a corner's place at the finest level [px]

const FeatureKernels& kernels = featureKernels();

/// A corner and its turn to be chosen.
struct RankedCorner {
  double turn = 0.0;
  int level = 0;
  cv::KeyPoint corner;  // in the level's own pixels
};

/// Direction from a corner to the intensity centroid of the disc around it [deg], x towards y.
float centroidDirection(const cv::Mat& image, const cv::Point2f& at) {
  const DiscMoments moments = kernels.discMoments(image.ptr<std::uint8_t>(cvRound(at.y)) + cvRound(at.x),
                                                  static_cast<std::ptrdiff_t>(image.step));
  return cv::fastAtan2(static_cast<float>(moments.y), static_cast<float>(moments.x));
}

/// Corners of a level, each cell of a grid giving its strongest, then its second and so on, at most `quota`.
std::vector<RankedCorner> cornersOfLevel(const cv::Mat& image, int level, int quota) {
  std::vector<RankedCorner> ranked;
  const cv::Size size(image.cols - 2 * kBorder, image.rows - 2 * kBorder);
  if (size.width < 1 || size.height < 1) return ranked;
  constexpr int kFastMargin = 3;
  const cv::Rect inside(kBorder - kFastMargin, kBorder - kFastMargin, size.width + 2 * kFastMargin,
                        size.height + 2 * kFastMargin);
  std::vector<cv::KeyPoint> corners;
  cv::FAST(image(inside), corners, kFastThreshold, true);
  std::sort(corners.begin(), corners.end(), [](const cv::KeyPoint& a, const cv::KeyPoint& b) {
    return std::make_tuple(-a.response, a.pt.y, a.pt.x) < std::make_tuple(-b.response, b.pt.y, b.pt.x);
  });

  const double side =
      std::max(1.0, std::sqrt(static_cast<double>(kFeaturesPerCell) * size.area() / std::max(quota, 1)));
  const int columns = static_cast<int>(inside.width / side) + 1;
  const int rows = static_cast<int>(inside.height / side) + 1;
  std::vector<int> taken(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  for (const cv::KeyPoint& corner : corners) {
    const int cell = static_cast<int>(corner.pt.y / side) * columns + static_cast<int>(corner.pt.x / side);
    ranked.push_back({static_cast<double>(taken[static_cast<std::size_t>(cell)]++), level, corner});
    ranked.back().corner.pt += cv::Point2f(static_cast<float>(inside.x), static_cast<float>(inside.y));
  }
  std::stable_sort(ranked.begin(), ranked.end(),
                   [](const RankedCorner& a, const RankedCorner& b) { return a.turn < b.turn; });
  ranked.resize(std::min(ranked.size(), static_cast<std::size_t>(quota)));
  // Turns from 0 to 1 whatever the quota: levels then share any number of features as they share all of them.
  for (std::size_t i = 0; i < ranked.size(); ++i) ranked[i].turn = static_cast<double>(i) / quota;
  return ranked;
}

}  // namespace

cv::Mat recallGrey(const cv::Mat& image) {
  const bool depth_known = image.depth() == CV_8U || image.depth() == CV_16U;
  const int channels = image.channels();
  if (image.empty() || !depth_known || (channels != 1 && channels != 3 && channels != 4)) {
    throwBadValue("image", cv::typeToString(image.type()),
                  "it must be a non-empty 8- or 16-bit image of 1, 3 or 4 channels");
  }
  cv::Mat grey = image;
  if (channels != 1) cv::cvtColor(image, grey, channels == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  if (grey.depth() == CV_16U) {
    cv::Mat bytes;
    grey.convertTo(bytes, CV_8U, 1.0 / 257.0);
    return bytes;
  }
  return grey.data == image.data ? grey.clone() : grey;
}

RecallFeatures extractRecallFeatures(const cv::Mat& grey, const CameraModel& camera, int count) {
  const double pixels = static_cast<double>(grey.cols) * grey.rows;
  const double shrink = pixels > kMaxPixels ? std::sqrt(kMaxPixels / pixels) : 1.0;
  std::vector<cv::Mat> levels(kLevels);
  double shares = 0.0;
  for (int level = 0; level < kLevels; ++level) shares += std::pow(kScaleFactor, -level);
  std::vector<RankedCorner> corners;
  for (int level = 0; level < kLevels; ++level) {
    const double scale = shrink * std::pow(kScaleFactor, -level);
    const cv::Size size(cvRound(grey.cols * scale), cvRound(grey.rows * scale));
    if (std::min(size.width, size.height) <= 2 * kBorder) break;
    cv::Mat& image = levels[static_cast<std::size_t>(level)];
    if (size == grey.size()) {
      image = grey;
    } else if (level == 0) {
      cv::resize(grey, image, size, 0.0, 0.0, cv::INTER_AREA);
    } else {
      cv::resize(levels[static_cast<std::size_t>(level - 1)], image, size, 0.0, 0.0, cv::INTER_LINEAR);
    }
    const int quota = static_cast<int>(std::ceil(count * std::pow(kScaleFactor, -level) / shares));
    const std::vector<RankedCorner> of_level = cornersOfLevel(image, level, quota);
    corners.insert(corners.end(), of_level.begin(), of_level.end());
  }
  std::stable_sort(corners.begin(), corners.end(),
                   [](const RankedCorner& a, const RankedCorner& b) { return a.turn < b.turn; });
  corners.resize(std::min(corners.size(), static_cast<std::size_t>(count)));

  RecallFeatures features;
  features.descriptors.create(static_cast<int>(corners.size()), kRecallDescriptorBytes, CV_8U);
  const cv::Ptr<cv::ORB> orb =
      cv::ORB::create(count, 1.2F, 1, kBorder, 0, 2, cv::ORB::FAST_SCORE, 2 * kDiscRadius + 1);
  std::vector<Eigen::Vector2d> places(corners.size());
  for (int level = 0; level < kLevels; ++level) {
    const cv::Mat& image = levels[static_cast<std::size_t>(level)];
    std::vector<cv::KeyPoint> of_level;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (corners[i].level != level) continue;
      const cv::Point2f at = corners[i].corner.pt;
      // Pixel centres lie at whole numbers: the image's edge is at -1/2 at every level.
      places[i] = {(static_cast<double>(at.x) + 0.5) * grey.cols / image.cols - 0.5,
                   (static_cast<double>(at.y) + 0.5) * grey.rows / image.rows - 0.5};
      of_level.push_back(corners[i].corner);
      of_level.back().angle = centroidDirection(image, at);
      of_level.back().class_id = static_cast<int>(i);
    }
    if (of_level.empty()) continue;
    cv::Mat descriptors;
    orb->compute(image, of_level, descriptors);
    for (int row = 0; row < descriptors.rows; ++row) {
      descriptors.row(row).copyTo(features.descriptors.row(of_level[static_cast<std::size_t>(row)].class_id));
    }
  }
  places = camera.undistort(places);
  const double focal = 0.5 * (camera.fx + camera.fy);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    features.bearings.emplace_back(static_cast<float>((places[i].x() - camera.cx) / camera.fx),
                                   static_cast<float>((places[i].y() - camera.cy) / camera.fy));
    features.sigmas.push_back(
        static_cast<float>(kCornerSigma * std::pow(kScaleFactor, corners[i].level) / (shrink * focal)));
  }
  return features;
}

RecallFeatures firstFeatures(const RecallFeatures& features, std::size_t count) {
  const std::size_t n = std::min(count, features.size());
  RecallFeatures first;
  first.bearings.assign(features.bearings.begin(),
                        features.bearings.begin() + static_cast<std::ptrdiff_t>(n));
  first.sigmas.assign(features.sigmas.begin(), features.sigmas.begin() + static_cast<std::ptrdiff_t>(n));
  first.descriptors = features.descriptors.rowRange(0, static_cast<int>(n)).clone();
  return first;
}

std::vector<RecallMatch> matchRecallFeatures(const RecallFeatures& first, const RecallFeatures& second) {
  std::vector<RecallMatch> matches;
  if (first.size() == 0 || second.size() < 2) return matches;
  struct Best {
    int distance = kMaxDistance + 1;
    int first = -1;
  };
  std::vector<Best> best_of_second(second.size());
  std::vector<int> distances(second.size());
  for (int i = 0; i < static_cast<int>(first.size()); ++i) {
    kernels.hammingDistances(first.descriptors.ptr(i), second.descriptors.ptr(), second.size(),
                             distances.data());
    const auto best = std::min_element(distances.begin(), distances.end());
    const int distance = *best;
    // A later feature of the first image may win a second one over, an equal one may not.
    for (std::size_t j = 0; j < second.size(); ++j) {
      if (distances[j] < best_of_second[j].distance) best_of_second[j] = {distances[j], i};
    }
    if (distance > kMaxDistance) continue;
    const auto at = static_cast<std::size_t>(best - distances.begin());
    // The same corner found at two pyramid levels is no rival.
    const float near = kSameCorner * second.sigmas[at];
    int rival = std::numeric_limits<int>::max();
    for (std::size_t j = 0; j < second.size(); ++j) {
      if (distances[j] < rival && (second.bearings[j] - second.bearings[at]).norm() > near)
        rival = distances[j];
    }
    if (distance < kMaxRatio * rival) matches.push_back({i, static_cast<int>(at)});
  }
  matches.erase(std::remove_if(matches.begin(), matches.end(),
                               [&](const RecallMatch& match) {
                                 return best_of_second[static_cast<std::size_t>(match.second)].first !=
                                        match.first;
                               }),
                matches.end());
  return matches;
}

}  // namespace ratslam
