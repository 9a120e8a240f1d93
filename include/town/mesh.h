/// Textured triangles, and the simple bodies the town is made of.
///
/// World axes are those of a camera that looks ahead at the start (KITTI): x right, y down, z forward [m].
/// A face is seen from the side from which its corners run counter-clockwise; it is lit by a fixed sun and
/// sky.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

namespace ratslam {

struct MeshVertex {
  Eigen::Vector3f position;  ///< world [m]
  Eigen::Vector2f texture;   ///< [repeats]
  float light = 1.0F;        ///< factor on the texture's value
};

/// What a surface looks like apart from its shape.
struct Finish {
  std::uint16_t texture = 0;  ///< index into the texture library
  float brightness = 1.0F;    ///< factor on the texture's value
  std::uint8_t layer = 0;     ///< painted onto a surface: wins over lower layers within 0.2% of its depth
  /// Stains: the texture coordinates times `stain_scale` plus `stain_offset` look up the stain texture.
  float stain_scale = 0.1F;
  Eigen::Vector2f stain_offset = Eigen::Vector2f::Zero();
};

struct MeshTriangle {
  std::array<MeshVertex, 3> corner;
  std::uint16_t texture = 0;
  std::uint8_t layer = 0;
  float stain_scale = 0.0F;
  Eigen::Vector2f stain_offset = Eigen::Vector2f::Zero();
};

/// Axes of a thing that stands upright: right and forward are level.
struct UprightFrame {
  /// @param x,z place [m]; @param height of the ground there [m], up; @param forward_x,forward_z direction,
  /// of length 1.
  UprightFrame(double x, double z, double height, double forward_x, double forward_z);
  /// World position of a point `right`, `up` and `forward` of the origin [m].
  Eigen::Vector3f at(double right, double up, double forward) const;

  double x, z, height, forward_x, forward_z;
};

/// A box in an UprightFrame [m].
struct Extent {
  double right0, right1, up0, up1, forward0, forward1;
};

/// Part of a texture [repeats]; v grows downwards.
struct TextureRect {
  double u0 = 0.0, v0 = 0.0, u1 = 1.0, v1 = 1.0;
};

class Mesh {
 public:
  /// Adds a triangle; its vertices' light is multiplied by the light that falls on it and the brightness.
  void addTriangle(const MeshVertex& a, const MeshVertex& b, const MeshVertex& c, const Finish& finish);
  /// Adds a flat quadrilateral with corners bottom left, bottom right, top right, top left as its beholder
  /// sees it.
  void addQuad(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
               const Eigen::Vector3f& d, const TextureRect& rect, const Finish& finish);
  /// Adds the four sides and the top of a box. Texture repeats every `metres_per_repeat`; 0 stretches it over
  /// each face.
  void addBox(const UprightFrame& frame, const Extent& extent, const Finish& finish,
              double metres_per_repeat);
  /// Adds an upright prism (a post, a trunk) round (right, forward) of the frame's origin.
  void addPrism(const UprightFrame& frame, double right, double forward, double radius, double up0,
                double up1, int sides, const Finish& finish, double metres_per_repeat);

  const std::vector<MeshTriangle>& triangles() const { return triangles_; }

 private:
  std::vector<MeshTriangle> triangles_;
};

}  // namespace ratslam
