/// Pictures of a town from any pose.
///
/// Steps: chunks of ground in the view's cone -> triangles in image coordinates -> z-buffer with four samples
/// a pixel
/// -> filtered textures, light and haze -> the lens (an ideal picture wide enough is drawn and resampled).
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <vector>

#include "town/camera.h"
#include "town/lens.h"
#include "town/rasteriser.h"
#include "town/town.h"

namespace ratslam {

class TownRenderer {
 public:
  /// @param town must outlive the renderer. @param threads does not change the pictures.
  /// @throws std::invalid_argument for bad cameras, and for lenses that fold the picture over itself.
  TownRenderer(const Town& town, const TownCamera& camera, int threads = 1);
  TownRenderer(const TownRenderer&) = delete;
  TownRenderer& operator=(const TownRenderer&) = delete;

  /// Grey picture, CV_8U. @param T_world_camera pose of the camera (x right, y down, z forward).
  /// @param moving triangles that are not part of the town (cars under way).
  cv::Mat render(const Eigen::Isometry3d& T_world_camera, const std::vector<MeshTriangle>& moving = {}) const;
  /// The same before rounding: CV_32F, nominally in [0,255].
  cv::Mat renderFloat(const Eigen::Isometry3d& T_world_camera,
                      const std::vector<MeshTriangle>& moving = {}) const;
  /// 1/depth [1/m] of the nearest surface in each pixel of the ideal (undistorted) picture, CV_32F, 0 in the
  /// sky.
  cv::Mat renderInverseDepth(const Eigen::Isometry3d& T_world_camera) const;
  /// The pinhole camera of the ideal picture: the camera itself if it has no distortion.
  const TownCamera& idealCamera() const { return lens_.ideal; }

 private:
  RasterImage draw(const Eigen::Isometry3d& T_world_camera, const std::vector<MeshTriangle>& moving,
                   bool with_depth) const;

  const Town& town_;
  LensMap lens_;
  Shader shader_;
  Rasteriser rasteriser_;
};

}  // namespace ratslam
