/// ORB features of one image for recall geometry.
///
/// They are the features of feature_extractor.h, ordered such that the first n cover the image for any n. Their
/// positions are undistorted bearings (X/Z, Y/Z) in the camera frame (x right, y down, z forward). An image with more
/// pixels than the features need is shrunk.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ratslam/camera/camera_model.h"

namespace ratslam {

struct RecallFeatures {
  std::vector<Eigen::Vector2f> bearings;  ///< (X/Z, Y/Z)
  std::vector<float> sigmas;              ///< standard deviation of a corner's bearing at its pyramid level
  cv::Mat descriptors;                    ///< one row of kRecallDescriptorBytes per feature, CV_8U

  std::size_t size() const { return bearings.size(); }
};

constexpr int kRecallDescriptorBytes = 32;

/// @param grey 8-bit, 1 channel.
/// @return at most `count` features, ordered such that the first n cover the image as well as n features can;
/// empty if the image has no corners or is smaller than a descriptor's patch.
RecallFeatures extractRecallFeatures(const cv::Mat& grey, const CameraModel& camera, int count);

/// The first `count` features, or all.
RecallFeatures firstFeatures(const RecallFeatures& features, std::size_t count);

/// Indices of two features that match.
struct RecallMatch {
  int first = 0;
  int second = 0;
};

/// Mutually best matches that are clearly better than the second best (Lowe's ratio), ordered by the first index.
std::vector<RecallMatch> matchRecallFeatures(const RecallFeatures& first, const RecallFeatures& second);

}  // namespace ratslam
