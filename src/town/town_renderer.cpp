#include "town/town_renderer.h"

#include <algorithm>
#include <array>
#include <opencv2/imgproc.hpp>

#include "ratslam/common/params.h"

namespace ratslam {
namespace {

/// Inward normals, in camera axes, of the planes that bound what the camera sees; all go through the camera.
std::array<Eigen::Vector3d, 4> viewPlanes(const TownCamera& camera) {
  const double left = (-0.5 - camera.cx) / camera.fx;
  const double right = (camera.width - 0.5 - camera.cx) / camera.fx;
  const double top = (-0.5 - camera.cy) / camera.fy;
  const double bottom = (camera.height - 0.5 - camera.cy) / camera.fy;
  return {Eigen::Vector3d(1.0, 0.0, -left).normalized(), Eigen::Vector3d(-1.0, 0.0, right).normalized(),
          Eigen::Vector3d(0.0, 1.0, -top).normalized(), Eigen::Vector3d(0.0, -1.0, bottom).normalized()};
}

}  // namespace

TownRenderer::TownRenderer(const Town& town, const TownCamera& camera, int threads)
    : town_(town),
      lens_(makeLensMap(camera)),
      shader_(town.textures(), lens_.ideal),
      rasteriser_(shader_, lens_.ideal, threads) {
  if (threads < 1 || threads > 64) throwBadValue("threads", threads, "it must lie within [1, 64]");
}

RasterImage TownRenderer::draw(const Eigen::Isometry3d& T_world_camera,
                               const std::vector<MeshTriangle>& moving, bool with_depth) const {
  const Eigen::Isometry3d T_camera_world = T_world_camera.inverse(Eigen::Isometry);
  const std::array<Eigen::Vector3d, 4> planes = viewPlanes(lens_.ideal);
  std::vector<ScreenTriangle> triangles;
  const auto project = [&](const std::vector<MeshTriangle>& surfaces) {
    for (const MeshTriangle& surface : surfaces)
      if (const auto triangle = projectTriangle(surface, T_camera_world, lens_.ideal))
        triangles.push_back(*triangle);
  };
  // Near chunks first: what they hide is found hidden, and neither stored nor overwritten.
  std::vector<std::pair<double, const Town::Chunk*>> visible;
  for (const Town::Chunk& chunk : town_.chunks()) {
    const Eigen::Vector3d centre = T_camera_world * chunk.centre.cast<double>();
    const double radius = chunk.radius;
    if (centre.norm() - radius > Shader::kViewDistance || centre.z() < -radius) continue;
    bool in_view = true;
    for (const Eigen::Vector3d& plane : planes) in_view = in_view && plane.dot(centre) > -radius;
    if (in_view) visible.emplace_back(centre.norm(), &chunk);
  }
  std::stable_sort(visible.begin(), visible.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::size_t most = moving.size();
  for (const auto& [distance, chunk] : visible) most += chunk->triangles.size();
  triangles.reserve(most / 2);  // about half of them face away
  for (const auto& [distance, chunk] : visible) project(chunk->triangles);
  project(moving);
  return rasteriser_.draw(triangles, T_world_camera.linear().cast<float>(), with_depth);
}

cv::Mat TownRenderer::renderFloat(const Eigen::Isometry3d& T_world_camera,
                                  const std::vector<MeshTriangle>& moving) const {
  cv::Mat grey = draw(T_world_camera, moving, false).grey;
  if (lens_.map_x.empty()) return grey;
  cv::Mat distorted;
  cv::remap(grey, distorted, lens_.map_x, lens_.map_y, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  return distorted;
}

cv::Mat TownRenderer::render(const Eigen::Isometry3d& T_world_camera,
                             const std::vector<MeshTriangle>& moving) const {
  cv::Mat grey;
  renderFloat(T_world_camera, moving).convertTo(grey, CV_8U);
  return grey;
}

cv::Mat TownRenderer::renderInverseDepth(const Eigen::Isometry3d& T_world_camera) const {
  return draw(T_world_camera, {}, true).inverse_depth;
}

}  // namespace ratslam
