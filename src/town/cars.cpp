#include <algorithm>
#include <cmath>

#include "ratslam/common/angles.h"
#include "town/hash.h"
#include "town/town_parts.h"

namespace ratslam {
namespace {

struct CarShape {
  double half_width, half_length, bonnet, roof;  ///< [m]; heights of the bonnet and of the roof
  double cabin_back, cabin_front;                ///< ends of the roof, forward [m]
  int paint;
};

CarShape drawShape(std::uint64_t kind) {
  HashStream random(kind);
  CarShape shape{};
  const int body = random.index(4);  // saloon, hatchback, estate, van
  shape.half_width = random.range(0.82, 0.90);
  shape.half_length = body == 3 ? random.range(2.2, 2.5) : random.range(1.85, 2.3);
  shape.bonnet = body == 3 ? 1.15 : random.range(0.85, 1.0);
  shape.roof = body == 3 ? random.range(1.9, 2.2) : random.range(1.38, 1.52);
  shape.cabin_back = body == 0 ? -0.45 * shape.half_length : -0.88 * shape.half_length;
  shape.cabin_front = body == 3 ? 0.55 * shape.half_length : 0.1 * shape.half_length;
  shape.paint = random.index(TextureLibrary::kPaints);
  return shape;
}

/// Width and length of the roof relative to the waistline give the windows their slope.
void addCabin(Mesh& mesh, const TextureLibrary& textures, const UprightFrame& frame, const CarShape& shape,
              const Finish& paint) {
  Finish glass;
  glass.texture = textures.carGlass();
  glass.stain_scale = 0.0F;
  const double w = shape.half_width - 0.04;
  const double top = w - 0.16;
  const double back = std::max(-shape.half_length + 0.05, shape.cabin_back - 0.45);
  const double front = shape.cabin_front + 0.75;
  const auto low = [&](double r, double f) { return frame.at(r, shape.bonnet, f); };
  const auto high = [&](double r, double f) { return frame.at(r, shape.roof, f); };
  const double b = shape.cabin_back;
  const double f = shape.cabin_front;
  mesh.addQuad(low(-w, back), low(w, back), high(top, b), high(-top, b), {}, glass);
  mesh.addQuad(low(w, front), low(-w, front), high(-top, f), high(top, f), {}, glass);
  mesh.addQuad(low(-w, front), low(-w, back), high(-top, b), high(-top, f), {0.0, 0.0, 2.0, 1.0}, glass);
  mesh.addQuad(low(w, back), low(w, front), high(top, f), high(top, b), {0.0, 0.0, 2.0, 1.0}, glass);
  mesh.addQuad(high(-top, b), high(top, b), high(top, f), high(-top, f), {0.0, 0.05, 1.0, 0.3}, paint);
}

/// A disc as a fan of triangles, `out` metres from the car's middle.
void addWheel(Mesh& mesh, const UprightFrame& frame, double side, double out, double forward,
              const Finish& finish) {
  constexpr double kRadius = 0.33;
  constexpr int kSides = 10;
  const auto vertex = [&](int i) {
    const double angle = side * 2.0 * kPi * i / kSides;
    return MeshVertex{
        frame.at(side * out, kRadius * (1.0 + std::sin(angle)), forward + kRadius * std::cos(angle)),
        Eigen::Vector2d(0.5 + 0.5 * std::cos(angle), 0.5 - 0.5 * std::sin(angle)).cast<float>(), 1.0F};
  };
  for (int i = 1; i + 1 < kSides; ++i) mesh.addTriangle(vertex(0), vertex(i), vertex(i + 1), finish);
}

}  // namespace

Extent carExtent(std::uint64_t kind) {
  const CarShape shape = drawShape(kind);
  return {-shape.half_width, shape.half_width, 0.0, shape.roof, -shape.half_length, shape.half_length};
}

Extent addCar(Mesh& mesh, const TextureLibrary& textures, const UprightFrame& frame, std::uint64_t kind) {
  const CarShape shape = drawShape(kind);
  const double w = shape.half_width;
  const double l = shape.half_length;
  constexpr double kSill = 0.22;
  Finish paint;
  paint.texture = textures.paint(shape.paint);
  paint.stain_scale = 0.0F;
  const auto at = [&](double r, double u, double f) { return frame.at(r, u, f); };
  Finish front = paint;
  front.texture = textures.carFront();
  Finish rear = paint;
  rear.texture = textures.carRear();
  mesh.addQuad(at(-w, kSill, -l), at(w, kSill, -l), at(w, shape.bonnet, -l), at(-w, shape.bonnet, -l), {},
               rear);
  mesh.addQuad(at(w, kSill, l), at(-w, kSill, l), at(-w, shape.bonnet, l), at(w, shape.bonnet, l), {}, front);
  mesh.addQuad(at(-w, kSill, l), at(-w, kSill, -l), at(-w, shape.bonnet, -l), at(-w, shape.bonnet, l), {},
               paint);
  mesh.addQuad(at(w, kSill, -l), at(w, kSill, l), at(w, shape.bonnet, l), at(w, shape.bonnet, -l), {}, paint);
  mesh.addQuad(at(-w, shape.bonnet, -l), at(w, shape.bonnet, -l), at(w, shape.bonnet, l),
               at(-w, shape.bonnet, l), {0.0, 0.1, 1.0, 0.4}, paint);
  addCabin(mesh, textures, frame, shape, paint);

  Finish dark = paint;
  dark.texture = textures.asphalt(1);
  dark.brightness = 0.35F;  // the shadow underneath
  dark.layer = 4;
  mesh.addQuad(at(-w - 0.1, 0.02, -l - 0.1), at(w + 0.1, 0.02, -l - 0.1), at(w + 0.1, 0.02, l + 0.1),
               at(-w - 0.1, 0.02, l + 0.1), {}, dark);
  Finish wheel = paint;
  wheel.texture = textures.wheel();
  for (const double f : {-0.62 * l, 0.62 * l})
    for (const double side : {-1.0, 1.0}) addWheel(mesh, frame, side, w + 0.015, f, wheel);
  return carExtent(kind);
}

}  // namespace ratslam
