#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"
#include "town/hash.h"
#include "town/town.h"
#include "town/town_parts.h"

namespace ratslam {
namespace {

/// A sphere squashed and dented at random.
void addCrownBlob(Mesh& mesh, const UprightFrame& frame, const Eigen::Vector3d& centre, double radius,
                  const Finish& finish, HashStream& random) {
  constexpr int kColumns = 9;
  constexpr int kRows = 6;
  std::array<std::array<MeshVertex, kColumns + 1>, kRows + 1> grid;
  for (int row = 0; row <= kRows; ++row)
    for (int column = 0; column <= kColumns; ++column) {
      MeshVertex& vertex = grid[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)];
      if (column == kColumns || ((row == 0 || row == kRows) && column > 0)) {
        vertex = grid[static_cast<std::size_t>(row)][0];
      } else {
        const double r = radius * random.range(0.78, 1.12);
        const double latitude = kPi * (0.5 - static_cast<double>(row) / kRows);
        const double longitude = 2.0 * kPi * (column + 0.5 * (row % 2)) / kColumns;
        const double level = r * std::cos(latitude);
        vertex.position =
            frame.at(centre.x() + level * std::cos(longitude), centre.y() + 0.85 * r * std::sin(latitude),
                     centre.z() + level * std::sin(longitude));
        vertex.light = static_cast<float>(0.80 + 0.30 * std::sin(latitude) + random.range(-0.12, 0.12));
      }
      const double repeats = 2.0 * kPi * radius / 2.2;
      vertex.texture =
          Eigen::Vector2d(std::round(repeats) * column / kColumns, 0.5 * repeats * row / kRows).cast<float>();
    }
  for (std::size_t row = 0; row < kRows; ++row)
    for (std::size_t column = 0; column < kColumns; ++column) {
      const MeshVertex& top_left = grid[row][column];
      const MeshVertex& top_right = grid[row][column + 1];
      const MeshVertex& bottom_left = grid[row + 1][column];
      const MeshVertex& bottom_right = grid[row + 1][column + 1];
      mesh.addTriangle(bottom_left, bottom_right, top_right, finish);
      mesh.addTriangle(bottom_left, top_right, top_left, finish);
    }
}

class Furnisher {
 public:
  explicit Furnisher(TownSite& site) : site_(site) {}

  void furnish(const RoadAxis& axis, double side, std::uint64_t seed) {
    parkCars(axis, side, hashOf(seed, 1));
    raisePosts(axis, side, hashOf(seed, 2));
    plant(axis, side, hashOf(seed, 3));
  }

 private:
  /// Frame `out` metres beside the axis on a side, looking along the road.
  UprightFrame beside(const RoadAxis& axis, double along, double side, double out) const {
    const auto i = std::min(static_cast<std::size_t>(along / RoadAxis::kStep), axis.samples.size() - 1);
    const RoadAxis::Sample& sample = axis.samples[i];
    const double x = sample.x + side * out * sample.forward_z;
    const double z = sample.z - side * out * sample.forward_x;
    return {x, z, site_.roads.height(x, z), sample.forward_x, sample.forward_z};
  }

  bool take(const UprightFrame& frame, const Extent& extent, double min_clearance) {
    const Footprint footprint = Footprint::of(frame, extent);
    if (clearance(site_.roads, footprint) < min_clearance || !site_.taken.isFree(footprint)) return false;
    site_.taken.add(footprint);
    return true;
  }

  void parkCars(const RoadAxis& axis, double side, std::uint64_t seed) {
    HashStream random(seed);
    bool busy = true;
    for (double along = 4.0; along < axis.length() - 4.0;) {
      if (random.chance(0.12)) busy = !busy;
      const std::uint64_t kind = random.next();
      if (busy && random.chance(0.75)) {
        UprightFrame frame = beside(axis, along, side, random.range(4.95, 5.05));
        if (random.chance(0.25)) {
          frame.forward_x = -frame.forward_x;
          frame.forward_z = -frame.forward_z;
        }
        if (take(frame, carExtent(kind), kParkingClearance)) addCar(site_.mesh, site_.textures, frame, kind);
      }
      along += random.range(5.2, 7.0);
    }
  }

  void raisePosts(const RoadAxis& axis, double side, std::uint64_t seed) {
    HashStream random(seed);
    Finish metal;
    metal.texture = site_.textures.plain();
    metal.brightness = 0.75F;
    for (double along = random.range(2.0, 20.0); along < axis.length(); along += random.range(9.0, 22.0)) {
      UprightFrame frame = beside(axis, along, side, 6.5);
      const int kind = random.index(4);
      const double turn = random.range(0.0, 1.0);
      const int sign = random.index(TextureLibrary::kSigns);
      if (!take(frame, {-0.15, 0.15, 0.0, 0.0, -0.15, 0.15}, kRoadHalfWidth + 0.2)) continue;
      if (kind == 0) {  // lamp
        site_.mesh.addPrism(frame, 0.0, 0.0, 0.09, 0.0, 6.2, 6, metal, 1.0);
        site_.mesh.addBox(frame,
                          {std::min(0.0, -side * 1.6), std::max(0.0, -side * 1.6), 6.1, 6.25, -0.1, 0.1},
                          metal, 1.0);
      } else if (kind == 3) {  // a column with posters
        Finish poster = metal;
        poster.texture = site_.textures.sign(sign);
        poster.brightness = 1.0F;
        site_.mesh.addPrism(frame, 0.0, 0.0, 0.45, 0.0, 2.6, 10, poster, 1.4);
      } else {  // traffic sign
        site_.mesh.addPrism(frame, 0.0, 0.0, 0.04, 0.0, 2.9, 5, metal, 1.0);
        Finish board = metal;
        board.texture = site_.textures.sign(sign);
        board.brightness = 1.1F;
        const double half = 0.3 + 0.25 * turn;
        site_.mesh.addBox(frame, {-half, half, 2.1, 2.1 + 2.0 * half * (kind == 1 ? 1.0 : 0.6), -0.06, -0.03},
                          board, 0.0);
      }
    }
  }

  void plant(const RoadAxis& axis, double side, std::uint64_t seed) {
    HashStream random(seed);
    for (double along = random.range(0.0, 8.0); along < axis.length(); along += random.range(5.0, 16.0)) {
      const bool street = random.chance(0.45);
      const double out = street ? 7.6 : random.range(11.0, 26.0);
      const double crown = street ? random.range(1.3, 2.1) : random.range(1.8, 3.4);
      const std::uint64_t kind = random.next();
      UprightFrame frame = beside(axis, along, side, out);
      const double room = street ? 0.4 : 0.5 * crown;
      if (take(frame, {-room, room, 0.0, 0.0, -room, room},
               street ? kRoadHalfWidth + 0.8 : kPavementEdge + 1.0))
        addTree(site_.mesh, site_.textures, frame, crown, kind);
    }
    Finish hedge;
    hedge.stain_scale = 0.2F;
    for (double along = 0.0; along < axis.length(); along += 3.0) {
      const int kind = random.index(5);
      UprightFrame frame = beside(axis, along, side, 8.95);
      const double height = random.range(0.7, 1.6);
      const Extent box{-0.25, 0.25, -0.5, height, -1.5, 1.5};
      if (kind > 2 || !take(frame, box, kPavementEdge)) continue;
      hedge.texture = kind == 0 ? site_.textures.leaves(0)
                                : (kind == 1 ? site_.textures.planks() : site_.textures.bareWall(0));
      site_.mesh.addBox(frame, box, hedge, 2.0);
    }
  }

  TownSite& site_;
};

}  // namespace

void addTree(Mesh& mesh, const TextureLibrary& textures, const UprightFrame& frame, double crown,
             std::uint64_t kind) {
  HashStream random(kind);
  Finish bark;
  bark.texture = textures.bark();
  const double trunk = random.range(2.2, 3.2);
  mesh.addPrism(frame, 0.0, 0.0, 0.10 + 0.06 * crown, -0.5, trunk + crown, 7, bark, 1.0);
  Finish leaves;
  leaves.texture = textures.leaves(random.index(TextureLibrary::kLeaves));
  leaves.brightness = static_cast<float>(random.range(0.8, 1.25));
  leaves.stain_scale = 0.0F;
  const double middle = trunk + 0.8 * crown;
  addCrownBlob(mesh, frame, {0.0, middle + 0.35 * crown, 0.0}, 0.85 * crown, leaves, random);
  const double start = random.range(0.0, 2.0 * kPi);
  for (int i = 0; i < 3; ++i) {
    const double angle = start + 2.0 * kPi * i / 3.0;
    const double radius = random.range(0.48, 0.62) * crown;
    const double up = middle + random.range(-0.15, 0.25) * crown;
    addCrownBlob(mesh, frame, {0.5 * crown * std::cos(angle), up, 0.5 * crown * std::sin(angle)}, radius,
                 leaves, random);
  }
}

void buildStreetFurniture(TownSite& site) {
  Furnisher furnisher(site);
  for (std::size_t a = 0; a < site.roads.axes().size(); ++a)
    for (const double side : {1.0, -1.0})
      furnisher.furnish(site.roads.axes()[a], side, hashOf(site.seed, 1000 + a, side > 0.0 ? 1 : 0));
}

}  // namespace ratslam
