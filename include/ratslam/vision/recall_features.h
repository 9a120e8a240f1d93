/// ORB features of one image for recall geometry: those of feature_extractor.h, in an order of which any number
/// of the first ones covers the image, with their places as bearings (X/Z, Y/Z) in the camera frame (x right,
/// y down, z forward), free of the lens. An image that has more pixels than features need is shrunk.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ratslam/camera/camera_model.h"

namespace ratslam {

struct RecallFeatures {
  std::vector<Eigen::Vector2f> bearings;  ///< (X/Z, Y/Z)
  std::vector<float> sigmas;  ///< how well a corner of its pyramid level is placed, in units of bearing
  cv::Mat descriptors;        ///< one row of kRecallDescriptorBytes a feature, CV_8U

  std::size_t size() const { return bearings.size(); }
};

constexpr int kRecallDescriptorBytes = 32;

/// @param grey 8-bit, 1 channel.
/// @return at most `count` features, ordered such that the first n cover the image as well as n features can;
/// none where the image has no corners or is smaller than a descriptor's patch.
RecallFeatures extractRecallFeatures(const cv::Mat& grey, const CameraModel& camera, int count);

/// The first `count` features, or all.
RecallFeatures firstFeatures(const RecallFeatures& features, std::size_t count);

/// Two features, by index, that look alike.
struct RecallMatch {
  int first = 0;
  int second = 0;
};

/// Pairs that are each other's best match, clearly better than the second best (Lowe's ratio), by first
/// index.
std::vector<RecallMatch> matchRecallFeatures(const RecallFeatures& first, const RecallFeatures& second);

}  // namespace ratslam
