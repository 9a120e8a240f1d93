#include "ratslam/vision/recall_features.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "ratslam/common/worker_pool.h"
#include "ratslam/simd/feature_kernels.h"
#include "ratslam/vision/feature_extractor.h"

namespace ratslam {
namespace {

constexpr double kScaleFactor = 1.25;  // between pyramid levels
constexpr int kLevels = 6;
constexpr double kMaxPixels = 800e3;  // larger images are shrunk
constexpr int kMaxDistance = 64;      // of a match [bits]
constexpr double kMaxRatio = 0.8;     // best distance / second best
constexpr float kSameCorner = 8.0F;   // two nearer features may be the same corner [sigma]
constexpr double kCornerSigma = 0.4;  // of a corner's position at the finest level [px]

const FeatureKernels& kernels = featureKernels();

/// Indices of the features, merged such that the levels take turns in proportion to their shares. So the first n
/// cover the image and the levels as all of them do.
/// @param features  level by level, each level in the order of selection
std::vector<int> byTurn(const std::vector<Feature>& features, int count) {
  std::vector<double> turns(features.size());
  for (std::size_t first = 0, end = 0; first < features.size(); first = end) {
    while (end < features.size() && features[end].level == features[first].level) ++end;
    for (std::size_t i = first; i < end; ++i)
      turns[i] = static_cast<double>(i - first) / static_cast<double>(end - first);
  }
  std::vector<int> order(features.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&turns](int a, int b) {
    return turns[static_cast<std::size_t>(a)] < turns[static_cast<std::size_t>(b)];
  });
  order.resize(std::min(order.size(), static_cast<std::size_t>(count)));
  return order;
}

}  // namespace

RecallFeatures extractRecallFeatures(const cv::Mat& grey, const CameraModel& camera, int count) {
  const double pixels = static_cast<double>(grey.cols) * grey.rows;
  const double shrink = pixels > kMaxPixels ? std::sqrt(kMaxPixels / pixels) : 1.0;
  cv::Mat finest = grey;
  if (shrink < 1.0) {
    cv::resize(grey, finest, {cvRound(shrink * grey.cols), cvRound(shrink * grey.rows)}, 0.0, 0.0,
               cv::INTER_AREA);
  }
  const ImagePyramid pyramid(finest, kLevels, kScaleFactor);
  ExtractorParams params;
  params.features = count + kLevels;  // each level rounds its share
  params.levels = kLevels;
  params.scale_factor = kScaleFactor;
  WorkerPool alone(1);
  cv::Mat descriptors;
  const std::vector<Feature> found = FeatureExtractor(params).extract(pyramid, descriptors, alone);
  const std::vector<int> order = byTurn(found, count);

  RecallFeatures features;
  features.descriptors.create(static_cast<int>(order.size()), kRecallDescriptorBytes, CV_8U);
  const double focal = 0.5 * (camera.fx + camera.fy);
  // Pixel centres are at whole coordinates, so the image's edge is at -1/2 for every size.
  const Eigen::Vector2d half(0.5, 0.5);
  const Eigen::Vector2d ratio(static_cast<double>(grey.cols) / finest.cols,
                              static_cast<double>(grey.rows) / finest.rows);
  std::vector<Eigen::Vector2d> places;
  for (const int index : order) {
    const Feature& feature = found[static_cast<std::size_t>(index)];
    descriptors.row(index).copyTo(features.descriptors.row(static_cast<int>(places.size())));
    places.emplace_back((feature.raw + half).cwiseProduct(ratio) - half);
    features.sigmas.push_back(
        static_cast<float>(kCornerSigma * pyramid.scale(feature.level) / (shrink * focal)));
  }
  for (const Eigen::Vector2d& place : camera.undistort(places)) {
    features.bearings.emplace_back(static_cast<float>((place.x() - camera.cx) / camera.fx),
                                   static_cast<float>((place.y() - camera.cy) / camera.fy));
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
    // A later feature of the first image replaces the match of a second one only if it is better.
    for (std::size_t j = 0; j < second.size(); ++j) {
      if (distances[j] < best_of_second[j].distance) best_of_second[j] = {distances[j], i};
    }
    if (distance > kMaxDistance) continue;
    const auto at = static_cast<std::size_t>(best - distances.begin());
    // The same corner at another pyramid level does not count as second best.
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
