/// ORB features, spread over the image: Rublee et al., ORB: an efficient alternative to SIFT or SURF (ICCV
/// 2011), with FAST corners (Rosten and Drummond 2006) at each level of an image pyramid.
///
/// Steps at each level:
///  1. Compute FAST scores above the low threshold and keep the local maxima.
///  2. Select in each cell of a grid the corners that also pass the high threshold. A cell without any keeps its
///     weak corners.
///  3. Take the strongest corner of every cell, then the second of every cell, and so on, until the level's share
///     of the features is reached.
///  4. Compute the orientation by the intensity centroid, and the steered BRIEF descriptor on the smoothed level.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

#include "ratslam/common/worker_pool.h"
#include "ratslam/simd/feature_kernels.h"
#include "ratslam/vision/image_pyramid.h"

namespace ratslam {

struct Feature {
  Eigen::Vector2d raw = Eigen::Vector2d::Zero();    ///< position [raw px of level 0]
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< the same, undistorted
  float angle_deg = 0.0F;                           ///< direction of the intensity centroid, x towards y
  int level = 0;                                    ///< of the pyramid
};

struct ExtractorParams {
  int features = 2000;
  int levels = 8;
  double scale_factor = 1.2;
  int strong_threshold = 20;  ///< FAST [grey levels]
  int weak_threshold = 7;
};

/// A corner at one level of the pyramid.
struct Corner {
  int x = 0;
  int y = 0;
  int score = 0;  ///< FAST
};

class FeatureExtractor {
 public:
  /// @param level instruction set; the features do not depend on it.
  explicit FeatureExtractor(const ExtractorParams& params, SimdLevel level = bestSimdLevel());

  /// Features of an image. `pixel` equals `raw`: the caller undistorts it. @param descriptors [out] one row of 32
  /// bytes per feature. @param workers share the levels.
  std::vector<Feature> extract(const ImagePyramid& pyramid, cv::Mat& descriptors, WorkerPool& workers) const;

 private:
  struct LevelFeatures {
    std::vector<Feature> features;
    cv::Mat descriptors;
  };
  LevelFeatures featuresOfLevel(const ImagePyramid& pyramid, int level, int quota) const;
  std::vector<Corner> detect(const cv::Mat& image) const;
  std::vector<Corner> cornersOfLevel(const cv::Mat& image, int quota) const;
  cv::Mat smoothed(const cv::Mat& image) const;

  ExtractorParams params_;
  const FeatureKernels& kernels_;
  BriefPattern pattern_;
};

}  // namespace ratslam
