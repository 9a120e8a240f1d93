/// The builders of a town's parts. Each adds its part to the mesh, keeps clear of the roads and of ground
/// that is taken, and marks the ground it takes.
#pragma once

#include <cstdint>

#include "town/footprint.h"
#include "town/mesh.h"
#include "town/road_field.h"
#include "town/texture_library.h"

namespace ratslam {

/// What every builder needs.
struct TownSite {
  const RoadField& roads;
  const TextureLibrary& textures;
  std::uint64_t seed;
  Mesh& mesh;
  FootprintIndex& taken;
};

/// Road, kerbs, pavement and open ground as triangles over a lattice, clipped where the distance from the
/// road axes passes from one to the next.
void buildGround(TownSite& site);
/// Centre lines, zebra crossings, manholes and patches of other asphalt.
void buildMarkings(TownSite& site);
/// Houses in a row along both sides of every road, and taller blocks behind them.
void buildHouses(TownSite& site);
/// One house again and again along both sides of every road, every 12 m: nothing tells them apart.
void buildIdenticalHouses(TownSite& site);
/// Parked cars, trees, hedges, lamps, signs.
void buildStreetFurniture(TownSite& site);

/// Adds a car whose wheels stand on the frame's origin, looking forward. `kind` chooses body and paint.
/// @return its extent in the frame [m].
Extent addCar(Mesh& mesh, const TextureLibrary& textures, const UprightFrame& frame, std::uint64_t kind);
/// Extent of the car that addCar would add [m].
Extent carExtent(std::uint64_t kind);
/// Adds a tree with a crown of `crown` metres radius.
void addTree(Mesh& mesh, const TextureLibrary& textures, const UprightFrame& frame, double crown,
             std::uint64_t kind);

/// Smallest distance of a footprint's outline or inside from a road axis [m], sampled every 1.5 m at most.
double clearance(const RoadField& roads, const Footprint& footprint);

}  // namespace ratslam
