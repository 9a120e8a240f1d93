#include "ratslam/vision/feature_extractor.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <random>

namespace ratslam {
namespace {

constexpr int kBorder = 19;    // keeps disc, pattern and smoothing inside the image
constexpr int kCellSize = 24;  // of the grid that distributes the corners [px of the level]

/// Strongest first. Ties are in reading order, so that the order is unique.
bool stronger(const Corner& a, const Corner& b) {
  if (a.score != b.score) return a.score > b.score;
  if (a.y != b.y) return a.y < b.y;
  return a.x < b.x;
}

/// Corners in the cells of a grid.
class CornerGrid {
 public:
  explicit CornerGrid(const cv::Size& size)
      : columns_((size.width + kCellSize - 1) / kCellSize),
        rows_((size.height + kCellSize - 1) / kCellSize) {}

  /// Sorts corners into cells. A cell with a strong corner keeps only its strong ones.
  void fill(const std::vector<Corner>& corners, int strong_threshold) {
    std::vector<bool> has_strong(cells(), false);
    for (const Corner& corner : corners) {
      if (corner.score > strong_threshold) has_strong[cellOf(corner)] = true;
    }
    const auto counts = [&](const Corner& corner) {
      return corner.score > strong_threshold || !has_strong[cellOf(corner)];
    };
    begin_.assign(cells() + 1, 0);
    for (const Corner& corner : corners) {
      if (counts(corner)) ++begin_[cellOf(corner) + 1];
    }
    for (std::size_t cell = 0; cell < cells(); ++cell) begin_[cell + 1] += begin_[cell];
    sorted_.resize(begin_.back());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (const Corner& corner : corners) {
      if (counts(corner)) sorted_[next[cellOf(corner)]++] = corner;
    }
  }

  /// Takes each cell's strongest corner, then each cell's second, and so on, until there are `quota`.
  std::vector<Corner> takeInTurns(std::size_t quota) {
    std::vector<Corner> taken;
    taken.reserve(quota);
    std::vector<Corner> round;
    for (std::size_t turn = 0; taken.size() < quota; ++turn) {
      round.clear();
      for (std::size_t cell = 0; cell < cells(); ++cell) {
        const auto first = sorted_.begin() + static_cast<std::ptrdiff_t>(begin_[cell] + turn);
        const auto end = sorted_.begin() + static_cast<std::ptrdiff_t>(begin_[cell + 1]);
        if (begin_[cell] + turn >= begin_[cell + 1]) continue;
        std::iter_swap(first, std::min_element(first, end, stronger));
        round.push_back(*first);
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

 private:
  std::size_t cells() const { return static_cast<std::size_t>(columns_ * rows_); }
  std::size_t cellOf(const Corner& corner) const {
    return static_cast<std::size_t>((corner.y - kBorder) / kCellSize * columns_ +
                                    (corner.x - kBorder) / kCellSize);
  }

  int columns_;
  int rows_;
  std::vector<std::size_t> begin_;  // first corner of each cell; one more entry than cells
  std::vector<Corner> sorted_;
};

/// Point pairs drawn from a Gaussian around the corner (Calonder et al., BRIEF, ECCV 2010, G II), with a fixed seed.
BriefPattern makePattern() {
  constexpr int kDraws = 12;  // sum of uniform numbers: nearly Gaussian with variance kDraws / 12
  constexpr double kDeviation = 31.0 / 5.0;  // edge of the patch / 5
  std::mt19937 random(1);
  const auto draw = [&] {
    double sum = 0.0;
    for (int i = 0; i < kDraws; ++i) sum += static_cast<double>(random()) / 4294967296.0 - 0.5;
    return static_cast<int>(std::lround(kDeviation * sum));
  };
  BriefPattern pattern{};
  for (int i = 0; i < 2 * kBriefTests; ++i) {
    int x = 0;
    int y = 0;
    do {
      x = draw();
      y = draw();
    } while (x * x + y * y > kBriefReach * kBriefReach);
    pattern.x[i] = static_cast<std::int16_t>(x);
    pattern.y[i] = static_cast<std::int16_t>(y);
  }
  return pattern;
}

/// Appends the corners of a row. @param maxima scores of corners, 0 elsewhere. Its length is a multiple of a word,
/// filled with 0.
void appendCorners(const std::vector<std::uint8_t>& maxima, int y, std::vector<Corner>& corners) {
  // Most are 0, so check eight at a time.
  const std::uint8_t* const first = maxima.data();
  const int end = static_cast<int>(maxima.size()) - 7;
  for (int begin = 0; begin < end; begin += 8) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, first + begin, 8);
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    eight = __builtin_bswap64(eight);
#endif
    while (eight != 0) {
      const int bit = __builtin_ctzll(eight) & ~7;
      corners.push_back({begin + bit / 8 + kBorder, y, static_cast<int>(eight >> bit & 255U)});
      eight &= ~(std::uint64_t{255} << bit);
    }
  }
}

}  // namespace

FeatureExtractor::FeatureExtractor(const ExtractorParams& params, SimdLevel level)
    : params_(params), kernels_(featureKernels(level)), pattern_(makePattern()) {}

std::vector<Corner> FeatureExtractor::detect(const cv::Mat& image) const {
  // Circular buffer of the scores of three rows, with one more column on either side.
  const int width = image.cols - 2 * kBorder;
  std::vector<std::uint8_t> buffer(static_cast<std::size_t>(3 * (width + 2)));
  std::vector<std::uint8_t> maxima(static_cast<std::size_t>(width + 7));  // whole words
  const auto scores_of = [&](int y) { return buffer.data() + (y % 3) * (width + 2); };
  const auto score = [&](int y) {
    kernels_.cornerScores(image.ptr<std::uint8_t>(y) + kBorder - 1, static_cast<std::ptrdiff_t>(image.step),
                          width + 2, params_.weak_threshold, scores_of(y));
  };
  std::vector<Corner> corners;
  score(kBorder - 1);
  score(kBorder);
  for (int y = kBorder; y < image.rows - kBorder; ++y) {
    score(y + 1);
    const std::uint8_t* const around[3] = {scores_of(y - 1) + 1, scores_of(y) + 1, scores_of(y + 1) + 1};
    kernels_.localMaxima(around, width, maxima.data());
    appendCorners(maxima, y, corners);
  }
  return corners;
}

std::vector<Corner> FeatureExtractor::cornersOfLevel(const cv::Mat& image, int quota) const {
  const cv::Size inside(image.cols - 2 * kBorder, image.rows - 2 * kBorder);
  if (inside.width < kLeastRow || inside.height < 1) return {};
  CornerGrid grid(inside);
  grid.fill(detect(image), params_.strong_threshold);
  return grid.takeInTurns(static_cast<std::size_t>(quota));
}

cv::Mat FeatureExtractor::smoothed(const cv::Mat& image) const {
  // No descriptor reads pixels nearer to the edge.
  cv::Mat result(image.size(), CV_8UC1);
  std::vector<std::uint8_t> row(static_cast<std::size_t>(image.cols));
  for (int y = kSmoothReach; y < image.rows - kSmoothReach; ++y) {
    const std::uint8_t* rows[2 * kSmoothReach + 1];
    for (int i = 0; i <= 2 * kSmoothReach; ++i) rows[i] = image.ptr<std::uint8_t>(y + i - kSmoothReach);
    kernels_.smoothColumns(rows, image.cols, row.data());
    kernels_.smoothRow(row.data() + kSmoothReach, image.cols - 2 * kSmoothReach,
                       result.ptr<std::uint8_t>(y) + kSmoothReach);
  }
  return result;
}

FeatureExtractor::LevelFeatures FeatureExtractor::featuresOfLevel(const ImagePyramid& pyramid, int level,
                                                                  int quota) const {
  LevelFeatures found;
  const cv::Mat& image = pyramid.image(level);
  const std::vector<Corner> corners = cornersOfLevel(image, quota);
  if (corners.empty()) return found;
  const cv::Mat smooth = smoothed(image);
  found.descriptors.create(static_cast<int>(corners.size()), 32, CV_8UC1);
  found.features.reserve(corners.size());
  for (const Corner& corner : corners) {
    const DiscMoments moments = kernels_.discMoments(image.ptr<std::uint8_t>(corner.y) + corner.x,
                                                     static_cast<std::ptrdiff_t>(image.step));
    const double length =
        std::sqrt(static_cast<double>(moments.x) * moments.x + static_cast<double>(moments.y) * moments.y);
    const double cosine = length > 0.0 ? moments.x / length : 1.0;
    const double sine = length > 0.0 ? moments.y / length : 0.0;
    constexpr double kOne = 1 << 14;
    kernels_.describe(smooth.ptr<std::uint8_t>(corner.y) + corner.x, static_cast<std::ptrdiff_t>(smooth.step),
                      pattern_, static_cast<int>(std::lround(kOne * cosine)),
                      static_cast<int>(std::lround(kOne * sine)),
                      found.descriptors.ptr<std::uint8_t>(static_cast<int>(found.features.size())));
    const Eigen::Vector2d raw =
        pyramid.fromLevel({static_cast<double>(corner.x), static_cast<double>(corner.y)}, level);
    found.features.push_back(
        {raw, raw, cv::fastAtan2(static_cast<float>(moments.y), static_cast<float>(moments.x)), level});
  }
  return found;
}

std::vector<Feature> FeatureExtractor::extract(const ImagePyramid& pyramid, cv::Mat& descriptors,
                                               WorkerPool& workers) const {
  // A level's share is proportional to its edge length.
  double total = 0.0;
  for (int level = 0; level < pyramid.levels(); ++level) total += 1.0 / pyramid.scale(level);
  std::vector<LevelFeatures> found(static_cast<std::size_t>(pyramid.levels()));
  workers.run(pyramid.levels(), [&](int level) {
    const int quota = static_cast<int>(std::lround(params_.features / (total * pyramid.scale(level))));
    found[static_cast<std::size_t>(level)] = featuresOfLevel(pyramid, level, quota);
  });

  std::vector<Feature> features;
  descriptors = cv::Mat(0, 32, CV_8UC1);
  descriptors.reserve(static_cast<std::size_t>(params_.features + pyramid.levels()));
  for (const LevelFeatures& of_level : found) {
    features.insert(features.end(), of_level.features.begin(), of_level.features.end());
    if (!of_level.features.empty()) descriptors.push_back(of_level.descriptors);
  }
  return features;
}

}  // namespace ratslam
