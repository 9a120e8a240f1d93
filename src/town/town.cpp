#include "town/town.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "town/footprint.h"
#include "town/hash.h"
#include "town/town_parts.h"

namespace ratslam {

Town::Town(const std::vector<std::vector<RoadPoint>>& roads, std::uint64_t seed, bool identical_houses)
    : roads_(roads), textures_(hashOf(seed, 1)) {
  Mesh mesh;
  FootprintIndex taken;
  TownSite site{roads_, textures_, hashOf(seed, 2), mesh, taken};
  buildGround(site);
  if (identical_houses) {
    buildIdenticalHouses(site);
  } else {
    buildMarkings(site);
    buildHouses(site);
    buildStreetFurniture(site);
  }
  divide(mesh);
}

void Town::divide(const Mesh& mesh) {
  constexpr float kSquare = 16.0F;  // [m]
  std::map<std::pair<int, int>, Chunk> squares;
  for (const MeshTriangle& triangle : mesh.triangles()) {
    const Eigen::Vector3f middle =
        (triangle.corner[0].position + triangle.corner[1].position + triangle.corner[2].position) / 3.0F;
    squares[{static_cast<int>(std::floor(middle.x() / kSquare)),
             static_cast<int>(std::floor(middle.z() / kSquare))}]
        .triangles.push_back(triangle);
  }
  for (auto& [square, chunk] : squares) {
    Eigen::Vector3f low = chunk.triangles.front().corner[0].position;
    Eigen::Vector3f high = low;
    for (const MeshTriangle& triangle : chunk.triangles)
      for (const MeshVertex& vertex : triangle.corner) {
        low = low.cwiseMin(vertex.position);
        high = high.cwiseMax(vertex.position);
      }
    chunk.centre = 0.5F * (low + high);
    chunk.radius = 0.5F * (high - low).norm();
    chunks_.push_back(std::move(chunk));
  }
}

}  // namespace ratslam
