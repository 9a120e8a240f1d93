#include <cmath>
#include <optional>

#include "town/town.h"
#include "town/town_parts.h"

namespace ratslam {
namespace {

constexpr double kFine = 2.0;     // lattice near roads [m]
constexpr double kCoarse = 16.0;  // elsewhere [m]

struct GroundPoint {
  double x, z, height, distance;
};
using Polygon = std::vector<GroundPoint>;

GroundPoint between(const GroundPoint& a, const GroundPoint& b, double t) {
  return {a.x + t * (b.x - a.x), a.z + t * (b.z - a.z), a.height + t * (b.height - a.height),
          a.distance + t * (b.distance - a.distance)};
}

/// The part of a convex polygon whose distance is at least (`beyond`) or less than a limit, and where its
/// outline leaves the part and enters it again.
struct Cut {
  Polygon part;
  std::optional<GroundPoint> leaves, enters;
};

Cut cut(const Polygon& polygon, double limit, bool beyond) {
  Cut result;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const GroundPoint& a = polygon[i];
    const GroundPoint& b = polygon[(i + 1) % polygon.size()];
    const bool a_in = (a.distance >= limit) == beyond;
    const bool b_in = (b.distance >= limit) == beyond;
    if (a_in) result.part.push_back(a);
    if (a_in != b_in) {
      const GroundPoint crossing = between(a, b, (limit - a.distance) / (b.distance - a.distance));
      result.part.push_back(crossing);
      (a_in ? result.leaves : result.enters) = crossing;
    }
  }
  return result;
}

class GroundBuilder {
 public:
  explicit GroundBuilder(TownSite& site) : site_(site) {
    const auto finish = [](std::uint16_t texture, float brightness) {
      Finish f;
      f.texture = texture;
      f.brightness = brightness;
      f.stain_scale = 0.11F;
      f.stain_offset = {0.37F, 0.11F};
      return f;
    };
    road_ = finish(site.textures.asphalt(0), 0.92F);
    pavement_ = finish(site.textures.pavement(), 0.85F);
    open_ = finish(site.textures.grass(), 0.9F);
    kerb_ = finish(site.textures.kerb(), 1.0F);
    kerb_.stain_scale = 0.05F;
  }

  /// Adds a square of `cells` times `cells` lattice cells.
  void addSquare(double x, double z, int cells, double cell) {
    Polygon lattice;
    for (int row = 0; row <= cells; ++row)
      for (int column = 0; column <= cells; ++column)
        lattice.push_back(point(x + column * cell, z + row * cell));
    const auto at = [&](int column, int row) {
      return lattice[static_cast<std::size_t>(row * (cells + 1) + column)];
    };
    for (int row = 0; row < cells; ++row)
      for (int column = 0; column < cells; ++column) {
        addTriangle({at(column, row), at(column + 1, row), at(column + 1, row + 1)});
        addTriangle({at(column, row), at(column + 1, row + 1), at(column, row + 1)});
      }
  }

 private:
  GroundPoint point(double x, double z) const {
    return {x, z, site_.roads.height(x, z), site_.roads.distance(x, z)};
  }

  void addTriangle(const Polygon& triangle) {
    addPolygon(cut(triangle, kRoadHalfWidth, false).part, road_, TextureLibrary::kAsphaltMetres, 0.0);
    const Cut beyond = cut(triangle, kRoadHalfWidth, true);
    addPolygon(cut(beyond.part, kPavementEdge, false).part, pavement_, 4.0, kKerbHeight);
    addPolygon(cut(beyond.part, kPavementEdge, true).part, open_, 6.4, kKerbHeight);
    // Counter-clockwise around the part beyond the kerb, that part is on the left. So seen from the road, the outline
    // enters it on the right.
    if (beyond.leaves && beyond.enters) addKerb(*beyond.leaves, *beyond.enters);
  }

  void addPolygon(const Polygon& polygon, const Finish& finish, double metres, double lift) {
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
      site_.mesh.addTriangle(vertex(polygon[0], metres, lift), vertex(polygon[i], metres, lift),
                             vertex(polygon[i + 1], metres, lift), finish);
  }

  static MeshVertex vertex(const GroundPoint& p, double metres, double lift) {
    return {Eigen::Vector3d(p.x, -(p.height + lift), p.z).cast<float>(),
            Eigen::Vector2d(p.x / metres, p.z / metres).cast<float>(), 1.0F};
  }

  void addKerb(const GroundPoint& left, const GroundPoint& right) {
    const auto at = [](const GroundPoint& p, double lift) -> Eigen::Vector3f {
      return Eigen::Vector3d(p.x, -(p.height + lift), p.z).cast<float>();
    };
    const double length = std::hypot(right.x - left.x, right.z - left.z);
    const double start = std::abs(right.x - left.x) > std::abs(right.z - left.z) ? left.x : left.z;
    site_.mesh.addQuad(at(left, -0.02), at(right, -0.02), at(right, kKerbHeight), at(left, kKerbHeight),
                       {start, 0.0, start + length, 0.3}, kerb_);
  }

  TownSite& site_;
  Finish road_, pavement_, open_, kerb_;
};

}  // namespace

void buildGround(TownSite& site) {
  GroundBuilder builder(site);
  const RoadField& roads = site.roads;
  const double x_start = std::floor((roads.xMin() - RoadField::kMargin) / kCoarse) * kCoarse;
  const double z_start = std::floor((roads.zMin() - RoadField::kMargin) / kCoarse) * kCoarse;
  for (double x = x_start; x < roads.xMax() + RoadField::kMargin; x += kCoarse)
    for (double z = z_start; z < roads.zMax() + RoadField::kMargin; z += kCoarse) {
      const double half = 0.5 * kCoarse;
      const bool near_road = roads.distance(x + half, z + half) < kPavementEdge + kFine + half * 1.4143;
      builder.addSquare(x, z, near_road ? static_cast<int>(kCoarse / kFine) : 1, near_road ? kFine : kCoarse);
    }
}

}  // namespace ratslam
