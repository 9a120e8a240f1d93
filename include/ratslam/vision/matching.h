/// Finding known landmarks in a frame.
///
/// Two tools: descriptor search in a window around where a landmark should be (robust to a poor prediction),
/// and alignment of the landmark's warped patch (a fraction of a pixel, and independent of whether a corner
/// was detected there again). Sub-pixel places are what the accuracy of the whole path hangs on.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ratslam/vision/local_map.h"
#include "ratslam/vision/patch_alignment.h"

namespace ratslam {

/// Number of differing bits of two descriptors of 32 bytes.
int hammingDistance(const std::uint8_t* a, const std::uint8_t* b);

/// A landmark as a camera pose predicts it in the image.
struct ProjectedLandmark {
  std::size_t index = 0;                            ///< into the map's landmarks
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< undistorted
  Eigen::Matrix2d warp =
      Eigen::Matrix2d::Identity();  ///< d(undistorted pixel here) / d(that in its reference)
  double scale = 1.0;               ///< of the pyramid level its feature should appear at
};

/// How the surroundings of an image point map into another view, if the surface faces the source camera.
/// @param pixel undistorted pixel in the source. @param depth of the point there.
/// @param T_target_source transform between the two cameras.
Eigen::Matrix2d predictWarp(const CameraModel& camera, const Eigen::Vector2d& pixel, double depth,
                            const RigidTransform& T_target_source);

/// The landmark in a camera of the given pose; nothing outside the image or far from the scale of its
/// reference.
std::optional<ProjectedLandmark> projectLandmark(const CameraModel& camera, const LocalMap& map,
                                                 std::size_t index, const RigidTransform& T_camera_world);

struct DescriptorSearch {
  double radius = 12.0;     ///< [px], times the predicted scale
  int max_distance = 64;    ///< [bits]
  double max_ratio = 0.85;  ///< of the best distance to the second best
};

/// The feature that looks like `descriptor` near a place. @param scale predicted scale of its level.
/// @return the feature's index, or -1.
int searchNear(const Frame& frame, const std::uint8_t* descriptor, const Eigen::Vector2d& pixel, double scale,
               const DescriptorSearch& search);

/// Aligns a landmark's patch in a frame. @param start undistorted pixel.
std::optional<Observation> alignLandmark(const CameraModel& camera, const LocalMap& map,
                                         const ProjectedLandmark& projected, const Frame& frame,
                                         const Eigen::Vector2d& start, const AlignmentLimits& limits);

}  // namespace ratslam
