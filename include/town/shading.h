/// Grey value of a point of a surface, or of the sky, in the image.
///
/// Surfaces: texture under an anisotropic filter (several trilinear samples along the longer axis of the
/// pixel's footprint, after McCormack et al., "Feline", SIGGRAPH 1999), times light, times stains, seen
/// through haze. Sky: clouds on a level layer, a skyline infinitely far away, both fading into the haze at
/// the horizon.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "town/screen_triangle.h"
#include "town/texture_library.h"

namespace ratslam {

class Shader {
 public:
  static constexpr double kViewDistance = 220.0;  ///< the haze hides everything beyond [m]

  /// @param textures must outlive the shader.
  Shader(const TextureLibrary& textures, const TownCamera& camera);

  /// Grey value in [0,255] of a surface at a pixel. The pixel must lie in, or within a pixel of, the outline.
  float surface(const ScreenTriangle& triangle, double x, double y) const;
  /// Grey value of the sky in a direction. @param direction world axes, any length.
  float sky(const Eigen::Vector3f& direction) const;
  /// Viewing ray of a pixel in camera axes, with z = 1.
  Eigen::Vector3f ray(double x, double y) const {
    return {static_cast<float>((x - camera_.cx) / camera_.fx),
            static_cast<float>((y - camera_.cy) / camera_.fy), 1.0F};
  }

 private:
  float hazeAt(float distance) const;

  const TextureLibrary& textures_;
  TownCamera camera_;
  std::vector<float> haze_;  ///< share of haze, every two metres
};

}  // namespace ratslam
