/// ORB features, spread over the image: Rublee et al., ORB: an efficient alternative to SIFT or SURF (ICCV
/// 2011), with FAST corners (Rosten and Drummond 2006) at each level of an image pyramid.
///
/// Steps at each level: FAST with a low threshold; in each cell of a grid the corners that also pass the high
/// threshold come first, and the weak ones are used where a cell has no strong one; every cell gives its
/// strongest corner, then its second, and so on, until the level's share of the features is reached;
/// orientation by the intensity centroid; steered BRIEF descriptor on the smoothed level.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <vector>

#include "ratslam/orb_odometry/image_pyramid.h"

namespace ratslam {

struct Feature {
  Eigen::Vector2d raw = Eigen::Vector2d::Zero();    ///< where it was found [raw px of level 0]
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

class FeatureExtractor {
 public:
  explicit FeatureExtractor(const ExtractorParams& params);

  /// Features of an image, `pixel` left equal to `raw`. @param descriptors [out] one row of 32 bytes a
  /// feature.
  std::vector<Feature> extract(const ImagePyramid& pyramid, cv::Mat& descriptors) const;

 private:
  std::vector<cv::KeyPoint> cornersOfLevel(const cv::Mat& image, int quota) const;

  ExtractorParams params_;
  cv::Ptr<cv::ORB> describer_;
  std::vector<int> row_half_widths_;  // of the disc that the intensity centroid is taken over
};

}  // namespace ratslam
