#include <algorithm>
#include <cmath>

#include "town/hash.h"
#include "town/town.h"
#include "town/town_parts.h"

namespace ratslam {
namespace {

constexpr double kStorey = 3.0;  // [m]

/// One house; its front is the near side of the frame, its ground floor starts at the frame's height.
class HouseBuilder {
 public:
  HouseBuilder(Mesh& mesh, const TextureLibrary& textures, const UprightFrame& frame, std::uint64_t seed)
      : mesh_(mesh), textures_(textures), frame_(frame), random_(seed) {
    wall_ = random_.index(TextureLibrary::kWalls);
    finish_.brightness = static_cast<float>(random_.range(0.72, 1.18));
    finish_.stain_scale = 0.17F;
    const double stain_v = random_.uniform();
    const double stain_u = random_.uniform();
    finish_.stain_offset = Eigen::Vector2d(stain_u, stain_v).cast<float>();
    shop_ = random_.chance(0.25);
    window_ = random_.index(TextureLibrary::kWindows);
  }

  void build(double width, double depth, int storeys) {
    body_ = {-0.5 * width, 0.5 * width, 0.0, storeys * kStorey, 0.0, depth};
    const auto side = [&](double r0, double f0, double r1, double f1, bool front) {
      addWall(r0, f0, r1, f1, storeys, front);
    };
    side(body_.right0, 0.0, body_.right1, 0.0, true);
    side(body_.right1, depth, body_.right0, depth, false);
    side(body_.right0, depth, body_.right0, 0.0, false);
    side(body_.right1, 0.0, body_.right1, depth, false);
    addPlinth();
    if (storeys <= 4 && random_.chance(0.7)) {
      addGable();
    } else {
      addFlatRoof();
    }
    addFrontDetails(storeys);
  }

 private:
  /// One side as a board of bays and storeys, from (r0,f0) to (r1,f1) as its beholder reads it from left to
  /// right.
  void addWall(double r0, double f0, double r1, double f1, int storeys, bool front) {
    const double length = std::hypot(r1 - r0, f1 - f0);
    const int bays = std::max(1, static_cast<int>(std::lround(length / TextureLibrary::kBayMetres)));
    const int door_bay = random_.index(bays);
    const double windows = front ? 0.92 : 0.45;
    for (int bay = 0; bay < bays; ++bay)
      for (int storey = 0; storey < storeys; ++storey) {
        const auto at = [&](int b, int s) {
          const double t = static_cast<double>(b) / bays;
          return frame_.at(r0 + t * (r1 - r0), s * kStorey, f0 + t * (f1 - f0));
        };
        Finish finish = finish_;
        finish.texture = textures_.bareWall(wall_);
        if (front && storey == 0 && bay == door_bay) {
          finish.texture = textures_.door(wall_, random_.index(TextureLibrary::kDoors));
        } else if (front && storey == 0 && shop_) {
          finish.texture = textures_.shop(wall_, random_.index(TextureLibrary::kShops));
        } else if (random_.chance(windows)) {
          finish.texture = textures_.window(
              wall_, random_.chance(0.7) ? window_ : random_.index(TextureLibrary::kWindows));
        }
        // Whole-numbered coordinates keep one bay's texture whole while stains run on across bays.
        const TextureRect rect{static_cast<double>(bay), static_cast<double>(-storey), bay + 1.0,
                               1.0 - storey};
        mesh_.addQuad(at(bay, storey), at(bay + 1, storey), at(bay + 1, storey + 1), at(bay, storey + 1),
                      rect, finish);
      }
  }

  /// The wall below the ground floor, down into sloping ground.
  void addPlinth() {
    Finish finish = finish_;
    finish.texture = textures_.bareWall(2);
    finish.brightness *= 0.7F;
    mesh_.addBox(frame_, {body_.right0 - 0.06, body_.right1 + 0.06, -4.0, 0.35, -0.06, body_.forward1 + 0.06},
                 finish, 3.0);
  }

  void addGable() {
    Finish roof = finish_;
    roof.texture = textures_.roof(random_.index(TextureLibrary::kRoofs));
    const double eaves = 0.45;
    const double middle = 0.5 * body_.forward1;
    const double top = body_.up1 + middle * random_.range(0.55, 0.95);
    const double low = body_.up1 - 0.15;
    const double r0 = body_.right0 - 0.25;
    const double r1 = body_.right1 + 0.25;
    const double slope = std::hypot(middle + eaves, top - low);
    const TextureRect rect{0.0, 0.0, (r1 - r0) / 3.0, slope / 3.0};
    mesh_.addQuad(frame_.at(r0, low, -eaves), frame_.at(r1, low, -eaves), frame_.at(r1, top, middle),
                  frame_.at(r0, top, middle), rect, roof);
    const double back = body_.forward1 + eaves;
    mesh_.addQuad(frame_.at(r1, low, back), frame_.at(r0, low, back), frame_.at(r0, top, middle),
                  frame_.at(r1, top, middle), rect, roof);
    Finish gable = finish_;
    gable.texture = textures_.bareWall(wall_);
    const auto vertex = [&](double right, double up, double forward, double u) {
      return MeshVertex{frame_.at(right, up, forward),
                        Eigen::Vector2d(u / kStorey, (body_.up1 - up) / kStorey).cast<float>(), 1.0F};
    };
    for (const double right : {body_.right0, body_.right1}) {
      const bool left_side = right < 0.0;
      const double near = left_side ? body_.forward1 : 0.0;
      mesh_.addTriangle(vertex(right, body_.up1, near, 0.0),
                        vertex(right, body_.up1, body_.forward1 - near, body_.forward1),
                        vertex(right, top - 0.1, middle, middle), gable);
    }
    const double chimney = random_.range(0.6 * body_.right0, 0.6 * body_.right1);
    Finish brick = finish_;
    brick.texture = textures_.bareWall(0);
    mesh_.addBox(frame_, {chimney, chimney + 0.7, body_.up1, top + 0.9, middle + 0.2, middle + 0.9}, brick,
                 3.0);
    for (double right = body_.right0 + 2.0; right < body_.right1 - 2.0; right += 3.4)
      if (random_.chance(0.35)) addDormer(right, top, middle);
  }

  void addDormer(double right, double top, double middle) {
    const double base = body_.up1 + 0.15 * (top - body_.up1);
    const Extent box{right - 0.8, right + 0.8, base, base + 1.5, 0.15 * middle, middle};
    mesh_.addBox(frame_, box, finishOf(textures_.bareWall(wall_)), 3.0);
    mesh_.addQuad(frame_.at(box.right0, box.up0, box.forward0 - 0.02),
                  frame_.at(box.right1, box.up0, box.forward0 - 0.02),
                  frame_.at(box.right1, box.up1, box.forward0 - 0.02),
                  frame_.at(box.right0, box.up1, box.forward0 - 0.02), {0.15, 0.1, 0.85, 0.8},
                  finishOf(textures_.window(wall_, window_)));
  }

  void addFlatRoof() {
    Finish cornice = finishOf(textures_.bareWall(wall_));
    cornice.brightness *= 1.15F;
    mesh_.addBox(frame_,
                 {body_.right0 - 0.3, body_.right1 + 0.3, body_.up1 - 0.1,
                  body_.up1 + random_.range(0.3, 0.9), -0.3, body_.forward1 + 0.3},
                 cornice, 3.0);
  }

  /// Ledges between storeys, balconies, drainpipes, signs.
  void addFrontDetails(int storeys) {
    const Finish trim = finishOf(textures_.kerb());
    if (random_.chance(0.5))
      for (int storey = 1; storey < storeys; ++storey)
        mesh_.addBox(
            frame_, {body_.right0, body_.right1, storey * kStorey - 0.1, storey * kStorey + 0.08, -0.12, 0.0},
            trim, 1.0);
    if (random_.chance(0.4)) {
      const double bay =
          (body_.right1 - body_.right0) / std::max(1.0, std::round((body_.right1 - body_.right0) / 3.0));
      const double right =
          body_.right0 + bay * random_.index(static_cast<int>((body_.right1 - body_.right0) / bay));
      for (int storey = 1; storey < storeys; ++storey)
        mesh_.addBox(
            frame_,
            {right + 0.3, right + bay - 0.3, storey * kStorey - 0.15, storey * kStorey + 0.95, -1.0, 0.0},
            finishOf(random_.chance(0.5) ? textures_.planks() : textures_.bareWall(4)), 1.5);
    }
    for (const double right : {body_.right0 + 0.12, body_.right1 - 0.12})
      if (random_.chance(0.6))
        mesh_.addBox(frame_, {right - 0.06, right + 0.06, 0.0, body_.up1, -0.1, 0.0},
                     finishOf(textures_.plain()), 1.0);
    const int signs = shop_ ? 2 : (random_.chance(0.25) ? 1 : 0);
    for (int i = 0; i < signs; ++i) {
      const double width = random_.range(1.2, 3.5);
      const double right = random_.range(body_.right0, std::max(body_.right0, body_.right1 - width));
      const double up = random_.range(2.4, 2.9);
      const Finish sign = finishOf(textures_.sign(random_.index(TextureLibrary::kSigns)));
      const double height = random_.range(0.5, 0.8);
      mesh_.addBox(frame_, {right, right + width, up, up + height, -0.15, 0.0}, sign, 0.0);
    }
  }

  Finish finishOf(std::uint16_t texture) const {
    Finish finish = finish_;
    finish.texture = texture;
    return finish;
  }

  Mesh& mesh_;
  const TextureLibrary& textures_;
  UprightFrame frame_;
  HashStream random_;
  Finish finish_;
  Extent body_{};
  int wall_ = 0, window_ = 0;
  bool shop_ = false;
};

/// Builds a house if its plot is free. @param side +1 to the right of the axis, -1 to the left.
bool tryHouse(TownSite& site, const RoadAxis::Sample& sample, double side, double setback, double width,
              double depth, int storeys, std::uint64_t seed) {
  // The frame looks away from the road, so that the house's front faces it.
  const double out_x = side * sample.forward_z;
  const double out_z = -side * sample.forward_x;
  UprightFrame frame(sample.x + setback * out_x, sample.z + setback * out_z, 0.0, out_x, out_z);
  const Extent plot{-0.5 * width, 0.5 * width, 0.0, 0.0, 0.0, depth};
  const Footprint footprint = Footprint::of(frame, plot);
  if (clearance(site.roads, footprint) < kBuildingClearance || !site.taken.isFree(footprint)) return false;
  site.taken.add(footprint);
  double low = 1e9;
  double high = -1e9;
  for (const double right : {plot.right0, plot.right1})
    for (const double forward : {0.0, depth}) {
      const Eigen::Vector3f corner = frame.at(right, 0.0, forward);
      const double height = site.roads.height(corner.x(), corner.z());
      low = std::min(low, height);
      high = std::max(high, height);
    }
  frame.height = std::min(0.5 * (low + high), low + 1.0) + kKerbHeight;
  HouseBuilder(site.mesh, site.textures, frame, seed).build(width, depth, storeys);
  return true;
}

}  // namespace

double clearance(const RoadField& roads, const Footprint& f) {
  const auto steps = [](double half) { return std::max(1, static_cast<int>(std::ceil(2.0 * half / 1.5))); };
  const int columns = steps(f.half_width);
  const int rows = steps(f.half_depth);
  double nearest = RoadField::kFar;
  for (int row = 0; row <= rows; ++row)
    for (int column = 0; column <= columns; ++column) {
      const double right = f.half_width * (2.0 * column / columns - 1.0);
      const double forward = f.half_depth * (2.0 * row / rows - 1.0);
      nearest = std::min(nearest, roads.distance(f.x + right * f.forward_z + forward * f.forward_x,
                                                 f.z - right * f.forward_x + forward * f.forward_z));
    }
  return nearest;
}

void buildHouses(TownSite& site) {
  constexpr double kTry = 2.0;  // [m] from one failed attempt to the next
  for (const bool back_row : {false, true})
    for (std::size_t a = 0; a < site.roads.axes().size(); ++a)
      for (const double side : {1.0, -1.0}) {
        const RoadAxis& axis = site.roads.axes()[a];
        HashStream random(hashOf(site.seed, 30 + a, (back_row ? 2 : 0) + (side > 0.0 ? 1 : 0)));
        for (double along = random.range(0.0, 4.0); along < axis.length();) {
          const double width = back_row ? random.range(14, 26) : random.range(7, 17);
          const double setback = back_row ? random.range(30, 46) : random.range(9.5, 11.5);
          const double depth = back_row ? random.range(10, 16) : random.range(7, 10.5);
          int storeys = back_row ? 3 + random.index(6) : 1 + random.index(2);
          if (!back_row) storeys += random.index(3);
          const double gap = random.chance(0.4) ? 0.05 : random.range(1.0, random.chance(0.15) ? 20.0 : 6.0);
          const std::uint64_t seed = random.next();
          const double middle = along + 0.5 * width;
          const auto i = static_cast<std::size_t>(middle / RoadAxis::kStep);
          if (i >= axis.samples.size()) break;
          const bool built =
              tryHouse(site, axis.samples[i], side, setback, width, depth, storeys, seed) ||
              (!back_row && tryHouse(site, axis.samples[i], side, setback, 6.0, 6.0, storeys, seed));
          along += built ? width + gap : kTry;
        }
      }
}

void buildIdenticalHouses(TownSite& site) {
  constexpr double kEvery = 12.0;  // [m]
  constexpr double kWidth = 10.0;
  constexpr double kSetback = 10.5;
  constexpr double kDepth = 9.0;
  constexpr int kStoreys = 2;
  for (const RoadAxis& axis : site.roads.axes())
    for (const double side : {1.0, -1.0})
      for (double middle = 0.5 * kEvery; middle < axis.length(); middle += kEvery) {
        const auto i = static_cast<std::size_t>(middle / RoadAxis::kStep);
        if (i >= axis.samples.size()) break;
        tryHouse(site, axis.samples[i], side, kSetback, kWidth, kDepth, kStoreys, site.seed);
      }
}

}  // namespace ratslam
