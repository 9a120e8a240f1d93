#include <algorithm>
#include <cmath>

#include "town/hash.h"
#include "town/town_parts.h"

namespace ratslam {
namespace {

class Marker {
 public:
  explicit Marker(TownSite& site) : site_(site) {}

  /// Paints a rectangle, lengthwise along the road at a sample of its axis, `right` of the axis.
  void addRectangle(const RoadAxis::Sample& sample, double right, double width, double length,
                    const Finish& finish, double metres_per_repeat) {
    const auto at = [&](double r, double f) -> Eigen::Vector3f {
      const double x = sample.x + r * sample.forward_z + f * sample.forward_x;
      const double z = sample.z - r * sample.forward_x + f * sample.forward_z;
      return Eigen::Vector3d(x, -(site_.roads.height(x, z) + 0.006), z).cast<float>();
    };
    const double r0 = right - 0.5 * width;
    const double r1 = right + 0.5 * width;
    const double f0 = -0.5 * length;
    const double f1 = 0.5 * length;
    TextureRect rect;
    if (metres_per_repeat > 0.0) {
      const double u = sample.x / metres_per_repeat;
      const double v = sample.z / metres_per_repeat;
      rect = {u, v, u + width / metres_per_repeat, v + length / metres_per_repeat};
    }
    site_.mesh.addQuad(at(r0, f0), at(r1, f0), at(r1, f1), at(r0, f1), rect, finish);
  }

 private:
  TownSite& site_;
};

constexpr double kCentreLine = -1.6;  // the axis is where cars drive: the middle of the street is to its left

std::size_t steps(double metres) { return static_cast<std::size_t>(metres / RoadAxis::kStep); }

/// How far the road bends over the next 6 m [rad].
double bend(const RoadAxis& axis, std::size_t i) {
  const auto& a = axis.samples[i];
  const auto& b = axis.samples[std::min(i + steps(6.0), axis.samples.size() - 1)];
  return std::abs(std::atan2(a.forward_x * b.forward_z - a.forward_z * b.forward_x,
                             a.forward_x * b.forward_x + a.forward_z * b.forward_z));
}

}  // namespace

void buildMarkings(TownSite& site) {
  Marker marker(site);
  Finish paint;
  paint.texture = site.textures.marking();
  paint.layer = 3;
  Finish patch;
  patch.layer = 1;
  Finish manhole = paint;
  manhole.layer = 2;
  manhole.texture = site.textures.manhole();
  manhole.stain_scale = 0.0F;
  HashStream random(hashOf(site.seed, 20));
  for (const RoadAxis& axis : site.roads.axes()) {
    const std::size_t count = axis.samples.size();
    double next_crossing = random.range(15.0, 40.0);
    for (std::size_t i = steps(3.0); i + steps(3.0) < count; i += steps(1.0)) {
      const RoadAxis::Sample& sample = axis.samples[i];
      const double along = RoadAxis::kStep * static_cast<double>(i);
      if (!sample.first_visit) continue;
      const bool straight = bend(axis, i) < 0.12 && bend(axis, i - steps(3.0)) < 0.12;
      if (straight && i % steps(7.0) == 0) marker.addRectangle(sample, kCentreLine, 0.16, 3.0, paint, 2.0);
      if (straight && along > next_crossing) {
        for (double right = -6.9; right < 4.0; right += 1.0)
          marker.addRectangle(sample, right, 0.5, 3.0, paint, 2.0);
        marker.addRectangle(axis.samples[i - steps(3.0)], 1.6, 5.6, 0.4, paint, 2.0);
        next_crossing = along + random.range(45.0, 110.0);
      }
      if (random.chance(0.055)) marker.addRectangle(sample, random.range(-3.0, 2.5), 0.7, 0.7, manhole, 0.0);
      if (random.chance(0.10)) {
        patch.texture = site.textures.asphalt(1 + random.index(TextureLibrary::kAsphalts - 1));
        patch.brightness = static_cast<float>(random.range(0.75, 1.1));
        const double length = random.range(0.8, 5.0);
        const double width = random.range(0.5, 2.2);
        const double right = random.range(-4.0, 3.5);
        marker.addRectangle(sample, right, width, length, patch, TextureLibrary::kAsphaltMetres);
      }
    }
  }
}

}  // namespace ratslam
