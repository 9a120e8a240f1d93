#include "town/screen_triangle.h"

#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

using Points = std::array<Eigen::Vector3d, 3>;

struct Outline {
  std::array<Eigen::Vector2d, 4> points;
  std::size_t count = 0;
};

Outline clipAndProject(const Points& corners, const TownCamera& camera) {
  Outline outline;
  const auto add = [&](const Eigen::Vector3d& p) {
    outline.points[outline.count++] = {camera.fx * p.x() / p.z() + camera.cx,
                                       camera.fy * p.y() / p.z() + camera.cy};
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d& a = corners[i];
    const Eigen::Vector3d& b = corners[(i + 1) % 3];
    const bool a_inside = a.z() >= kNearPlane;
    if (a_inside) add(a);
    if (a_inside != (b.z() >= kNearPlane)) {
      // Always from the inner to the outer end, so that the neighbour across this side finds the same point.
      const Eigen::Vector3d& inner = a_inside ? a : b;
      const Eigen::Vector3d& outer = a_inside ? b : a;
      const double t = (inner.z() - kNearPlane) / (inner.z() - outer.z());
      Eigen::Vector3d crossing = inner + t * (outer - inner);
      crossing.z() = kNearPlane;
      add(crossing);
    }
  }
  return outline;
}

}  // namespace

std::optional<ScreenTriangle> projectTriangle(const MeshTriangle& triangle,
                                              const Eigen::Isometry3d& T_camera_world,
                                              const TownCamera& camera) {
  const auto corner_in_camera = [&](std::size_t i) -> Eigen::Vector3d {
    return T_camera_world * triangle.corner[i].position.cast<double>();
  };
  const Points p{corner_in_camera(0), corner_in_camera(1), corner_in_camera(2)};
  if (p[0].z() < kNearPlane && p[1].z() < kNearPlane && p[2].z() < kNearPlane) return std::nullopt;
  const Points n{p[1].cross(p[2]), p[2].cross(p[0]), p[0].cross(p[1])};
  const double det = p[0].dot(n[0]);
  if (!(det < -1e-9)) return std::nullopt;  // seen from behind or edge on

  const Outline outline = clipAndProject(p, camera);
  Eigen::Vector2d low = outline.points[0];
  Eigen::Vector2d high = low;
  for (std::size_t i = 1; i < outline.count; ++i) {
    low = low.cwiseMin(outline.points[i]);
    high = high.cwiseMax(outline.points[i]);
  }
  if (high.x() < -0.5 || high.y() < -0.5 || low.x() > camera.width - 0.5 || low.y() > camera.height - 0.5)
    return std::nullopt;

  ScreenTriangle screen;
  const auto pixel = [](double x, int size) {
    return static_cast<int>(std::clamp(x + 0.5, 0.0, size - 1.0));
  };
  screen.x_first = pixel(low.x(), camera.width);
  screen.x_last = pixel(high.x(), camera.width);
  screen.y_first = pixel(low.y(), camera.height);
  screen.y_last = pixel(high.y(), camera.height);
  for (std::size_t i = 0; i < outline.count; ++i) {
    const Eigen::Vector2d& a = outline.points[i];
    const Eigen::Vector2d& b = outline.points[(i + 1) % outline.count];
    if (a.y() == b.y()) continue;
    const Eigen::Vector2d& top = a.y() < b.y() ? a : b;
    const Eigen::Vector2d& bottom = a.y() < b.y() ? b : a;
    screen.edges[static_cast<std::size_t>(screen.edge_count++)] = {
        top.y(), bottom.y(), top.x(), (bottom.x() - top.x()) / (bottom.y() - top.y())};
  }

  const double depth = std::max(kNearPlane, std::min({p[0].z(), p[1].z(), p[2].z()}));
  screen.nearest = static_cast<float>(1.0 / depth) * 1.0001F;  // beyond any rounding

  const auto field = [&](double at0, double at1, double at2) {
    const Eigen::Vector3d normal = (at0 * n[0] + at1 * n[1] + at2 * n[2]) / det;
    const double x = normal.x() / camera.fx;
    const double y = normal.y() / camera.fy;
    return LinearField{x, y, normal.z() - x * camera.cx - y * camera.cy};
  };
  const auto& corner = triangle.corner;
  screen.inverse_depth = field(1.0, 1.0, 1.0);
  screen.u = field(corner[0].texture.x(), corner[1].texture.x(), corner[2].texture.x());
  screen.v = field(corner[0].texture.y(), corner[1].texture.y(), corner[2].texture.y());
  screen.light = field(corner[0].light, corner[1].light, corner[2].light);
  screen.texture = triangle.texture;
  screen.layer = triangle.layer;
  screen.stain_scale = triangle.stain_scale;
  screen.stain_offset = triangle.stain_offset;
  return screen;
}

}  // namespace ratslam
