/// A town along given roads: ground, kerbs, markings, houses, trees, lamps, signs and parked cars, all drawn
/// from one seed. It is a function of the roads and the seed.
///
/// Cross section of a street, by distance from the road axis: road up to 6 m, pavement (12 cm higher) up
/// to 8.6 m, gardens and houses from 9.3 m on. Parked cars leave 4 m free on both sides of every axis.
#pragma once

#include <memory>
#include <vector>

#include "town/mesh.h"
#include "town/road_field.h"
#include "town/texture_library.h"

namespace ratslam {

constexpr double kRoadHalfWidth = 6.0;      ///< [m]
constexpr double kPavementEdge = 8.6;       ///< distance from the road axis where the pavement ends [m]
constexpr double kBuildingClearance = 9.3;  ///< no house is nearer to a road axis [m]
constexpr double kParkingClearance = 3.9;   ///< no parked car, tree or post is nearer to a road axis [m]
constexpr double kKerbHeight = 0.12;        ///< [m]

class Town {
 public:
  /// @param identical_houses all houses are the same one at equal distances, with nothing between them
  Town(const std::vector<std::vector<RoadPoint>>& roads, std::uint64_t seed, bool identical_houses = false);

  /// Triangles of one square of ground, with a sphere that holds them.
  struct Chunk {
    Eigen::Vector3f centre = Eigen::Vector3f::Zero();
    float radius = 0.0F;
    std::vector<MeshTriangle> triangles;
  };
  const std::vector<Chunk>& chunks() const { return chunks_; }
  const RoadField& roads() const { return roads_; }
  const TextureLibrary& textures() const { return textures_; }

 private:
  void divide(const Mesh& mesh);

  RoadField roads_;
  TextureLibrary textures_;
  std::vector<Chunk> chunks_;
};

}  // namespace ratslam
