/// Matching of known landmarks with a frame.
///
/// There are two methods. Descriptor search in a window around the predicted position is robust to a poor
/// prediction. Alignment of the landmark's warped patch is exact to a fraction of a pixel and needs no detected
/// corner. The accuracy of the whole path depends on these sub-pixel positions.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "ratslam/vision/local_map.h"
#include "ratslam/vision/patch_alignment.h"

namespace ratslam {

/// Number of differing bits of two descriptors of 32 bytes.
int hammingDistance(const std::uint8_t* a, const std::uint8_t* b);

/// Pairs of descriptors, each of which is the most similar to the other, in the order of the first.
/// @param first, second (rows, 32) bytes. @param most_distance [bits]. @param most_ratio bound on the distance of the
/// best / that of the second best (Lowe 2004).
std::vector<std::pair<std::size_t, std::size_t>> mutuallyMostSimilar(const cv::Mat& first,
                                                                     const cv::Mat& second, int most_distance,
                                                                     double most_ratio);

/// Projection of a landmark into the image of a camera pose.
struct ProjectedLandmark {
  std::size_t index = 0;                            ///< into the map's landmarks
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted
  /// d(undistorted pixel here) / d(undistorted pixel in its reference).
  Eigen::Matrix2d warp = Eigen::Matrix2d::Identity();
  double scale = 1.0;  ///< of the pyramid level at which its feature should appear
};

/// Affine map of the surroundings of an image point into another view, for a surface that faces the source camera.
/// @param pixel undistorted pixel in the source. @param depth of the point there.
/// @param T_target_source transform between the two cameras.
Eigen::Matrix2d predictWarp(const CameraModel& camera, const Eigen::Vector2d& pixel, double depth,
                            const RigidTransform& T_target_source);

/// Projects a landmark; none if it is outside the image or its scale is far from that of its reference.
std::optional<ProjectedLandmark> projectLandmark(const CameraModel& camera, const LocalMap& map,
                                                 std::size_t index, const RigidTransform& T_camera_world);

struct DescriptorSearch {
  double radius = 12.0;     ///< [px], times the predicted scale
  int max_distance = 64;    ///< [bits]
  double max_ratio = 0.85;  ///< best distance / second best
};

/// Finds the feature with the most similar descriptor near a position. @param scale predicted scale of its level.
/// @return the feature's index, or -1.
int searchNear(const Frame& frame, const std::uint8_t* descriptor, const Eigen::Vector2d& pixel, double scale,
               const DescriptorSearch& search);

/// Aligns a landmark's patch in a frame. @param start undistorted pixel.
std::optional<Observation> alignLandmark(const CameraModel& camera, const LocalMap& map,
                                         const ProjectedLandmark& projected, const Frame& frame,
                                         const Eigen::Vector2d& start, const AlignmentLimits& limits);

}  // namespace ratslam
