/// A z-buffer rasteriser that decides visibility at four points a pixel and shades each surface once a pixel.
///
/// Steps, tile by tile (tiles are independent, so any number of threads gives the same picture):
/// 1. each triangle is scan-converted at the four sample points (a rotated grid, which
///    smooths nearly level and nearly upright edges best); the nearest surface's number
///    stays;
/// 2. each pixel shades every surface it shows, at the centre of the samples it covers, and averages by their
///    number.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "town/screen_triangle.h"
#include "town/shading.h"

namespace ratslam {

struct RasterImage {
  cv::Mat grey;           ///< CV_32F, nominally in [0,255]
  cv::Mat inverse_depth;  ///< CV_32F [1/m], of the nearest surface in the pixel; 0 in the sky. Empty unless
                          ///< asked for
};

class Rasteriser {
 public:
  /// @param shader must outlive the rasteriser. @param threads at least 1.
  Rasteriser(const Shader& shader, const TownCamera& camera, int threads);
  /// @param R_world_camera turns viewing rays into world directions, for the sky.
  RasterImage draw(const std::vector<ScreenTriangle>& triangles, const Eigen::Matrix3f& R_world_camera,
                   bool with_depth) const;

 private:
  struct Tile;
  void drawTile(Tile& tile, const std::vector<ScreenTriangle>& triangles,
                const Eigen::Matrix3f& R_world_camera, RasterImage& image) const;

  const Shader& shader_;
  TownCamera camera_;
  int threads_;
};

}  // namespace ratslam
