/// A triangle of the town as the camera sees it: its outline in the image and its attributes as functions of
/// the pixel.
///
/// With the corners a, b, c in camera axes as columns of M, a viewing ray r = ((x-cx)/fx, (y-cy)/fy, 1) meets
/// the triangle's plane where the barycentric coordinates divided by depth are M^-1 r. So 1/depth, and every
/// attribute divided by depth, is linear in the pixel - also where a corner lies behind the camera (Olano &
/// Greer, "Triangle scan conversion using 2D homogeneous coordinates", 1997). Only the outline has to be
/// clipped.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>

#include "town/camera.h"
#include "town/mesh.h"

namespace ratslam {

/// x*px + y*py + c.
struct LinearField {
  double x = 0.0, y = 0.0, c = 0.0;
  double at(double px, double py) const { return x * px + y * py + c; }
};

struct ScreenTriangle {
  /// One side of the outline, from its upper to its lower end; level sides are left out.
  struct Edge {
    double y_top, y_bottom, x_top, slope;
  };
  std::array<Edge, 4> edges;  ///< a triangle clipped at the near plane has up to four sides
  int edge_count = 0;
  int x_first = 0, x_last = 0, y_first = 0, y_last = 0;  ///< pixels it may touch, within the image
  float nearest = 0.0F;                                  ///< largest 1/depth of the outline [1/m]
  LinearField inverse_depth;                             ///< 1/depth [1/m]
  LinearField u, v, light;                               ///< the attribute divided by depth
  std::uint16_t texture = 0;
  std::uint8_t layer = 0;
  float stain_scale = 0.0F;
  Eigen::Vector2f stain_offset = Eigen::Vector2f::Zero();
};

/// Nothing nearer to the camera than this is drawn [m].
constexpr double kNearPlane = 0.2;

/// @param T_camera_world world to camera (x right, y down, z forward).
/// @return none if it faces away or lies outside the image.
std::optional<ScreenTriangle> projectTriangle(const MeshTriangle& triangle,
                                              const Eigen::Isometry3d& T_camera_world,
                                              const TownCamera& camera);

}  // namespace ratslam
