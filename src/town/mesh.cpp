#include "town/mesh.h"

#include <Eigen/Geometry>
#include <cmath>

#include "ratslam/common/angles.h"

namespace ratslam {
namespace {

/// Light on a face: a sky that is brighter above, and a sun that comes from behind the right shoulder.
float lightOn(const Eigen::Vector3f& normal) {
  const Eigen::Vector3f to_sun = Eigen::Vector3f(0.52F, -0.68F, -0.52F).normalized();
  const float sun = std::max(0.0F, normal.dot(to_sun));
  return 0.62F + 0.08F * -normal.y() + 0.5F * sun;
}

}  // namespace

UprightFrame::UprightFrame(double origin_x, double origin_z, double ground, double ahead_x, double ahead_z)
    : x(origin_x), z(origin_z), height(ground), forward_x(ahead_x), forward_z(ahead_z) {}

Eigen::Vector3f UprightFrame::at(double right, double up, double forward) const {
  return Eigen::Vector3d(x + right * forward_z + forward * forward_x, -(height + up),
                         z - right * forward_x + forward * forward_z)
      .cast<float>();
}

void Mesh::addTriangle(const MeshVertex& a, const MeshVertex& b, const MeshVertex& c, const Finish& finish) {
  const Eigen::Vector3f normal = (b.position - a.position).cross(c.position - a.position);
  const float area = normal.norm();
  if (!(area > 1e-6F)) return;  // a clipped sliver: nothing to see, and no normal
  MeshTriangle triangle;
  triangle.corner = {a, b, c};
  const float light = lightOn(normal / area) * finish.brightness;
  for (MeshVertex& vertex : triangle.corner) vertex.light *= light;
  triangle.texture = finish.texture;
  triangle.layer = finish.layer;
  triangle.stain_scale = finish.stain_scale;
  triangle.stain_offset = finish.stain_offset;
  triangles_.push_back(triangle);
}

void Mesh::addQuad(const Eigen::Vector3f& a, const Eigen::Vector3f& b, const Eigen::Vector3f& c,
                   const Eigen::Vector3f& d, const TextureRect& rect, const Finish& finish) {
  const auto u0 = static_cast<float>(rect.u0);
  const auto u1 = static_cast<float>(rect.u1);
  const auto v0 = static_cast<float>(rect.v0);
  const auto v1 = static_cast<float>(rect.v1);
  const MeshVertex va{a, {u0, v1}, 1.0F};
  const MeshVertex vb{b, {u1, v1}, 1.0F};
  const MeshVertex vc{c, {u1, v0}, 1.0F};
  const MeshVertex vd{d, {u0, v0}, 1.0F};
  addTriangle(va, vb, vc, finish);
  addTriangle(va, vc, vd, finish);
}

void Mesh::addBox(const UprightFrame& frame, const Extent& e, const Finish& finish,
                  double metres_per_repeat) {
  const auto rect = [metres_per_repeat](double width, double height) {
    if (metres_per_repeat <= 0.0) return TextureRect{};
    return TextureRect{0.0, 0.0, width / metres_per_repeat, height / metres_per_repeat};
  };
  const double width = e.right1 - e.right0;
  const double height = e.up1 - e.up0;
  const double depth = e.forward1 - e.forward0;
  const auto corner = [&](int right, int up, int forward) {
    return frame.at(right == 0 ? e.right0 : e.right1, up == 0 ? e.up0 : e.up1,
                    forward == 0 ? e.forward0 : e.forward1);
  };
  addQuad(corner(0, 0, 0), corner(1, 0, 0), corner(1, 1, 0), corner(0, 1, 0), rect(width, height), finish);
  addQuad(corner(1, 0, 1), corner(0, 0, 1), corner(0, 1, 1), corner(1, 1, 1), rect(width, height), finish);
  addQuad(corner(0, 0, 1), corner(0, 0, 0), corner(0, 1, 0), corner(0, 1, 1), rect(depth, height), finish);
  addQuad(corner(1, 0, 0), corner(1, 0, 1), corner(1, 1, 1), corner(1, 1, 0), rect(depth, height), finish);
  addQuad(corner(0, 1, 0), corner(1, 1, 0), corner(1, 1, 1), corner(0, 1, 1), rect(width, depth), finish);
}

void Mesh::addPrism(const UprightFrame& frame, double right, double forward, double radius, double up0,
                    double up1, int sides, const Finish& finish, double metres_per_repeat) {
  const double edge = 2.0 * radius * std::sin(kPi / sides);
  for (int i = 0; i < sides; ++i) {
    const double a = 2.0 * kPi * i / sides;
    const double b = 2.0 * kPi * (i + 1) / sides;
    const auto at = [&](double angle, double up) {
      return frame.at(right + radius * std::cos(angle), up, forward + radius * std::sin(angle));
    };
    const TextureRect rect{i * edge / metres_per_repeat, 0.0, (i + 1) * edge / metres_per_repeat,
                           (up1 - up0) / metres_per_repeat};
    addQuad(at(a, up0), at(b, up0), at(b, up1), at(a, up1), rect, finish);
  }
}

}  // namespace ratslam
