#include "town/texture_library.h"

#include <algorithm>
#include <cmath>

#include "town/hash.h"
#include "town/painting.h"

namespace ratslam {

TextureLibrary::TextureLibrary(std::uint64_t seed) {
  paintGround(hashOf(seed, 1));
  paintWalls(hashOf(seed, 2));
  paintObjects(hashOf(seed, 3));
  paintSky(hashOf(seed, 4));
}

std::uint16_t TextureLibrary::add(Texture texture) {
  textures_.push_back(std::move(texture));
  return static_cast<std::uint16_t>(textures_.size() - 1);
}

void TextureLibrary::paintGround(std::uint64_t seed) {
  constexpr float kTone[kAsphalts] = {92.0F, 74.0F, 108.0F};
  for (int kind = 0; kind < kAsphalts; ++kind) {
    HashStream random(hashOf(seed, static_cast<std::uint64_t>(kind)));
    Canvas canvas(1024, kTone[kind]);
    canvas.addNoise(8, 4, 9.0F, random.next());
    canvas.addNoise(64, 4, 20.0F, random.next(), 0.85F);
    for (int stone = 0; stone < 1800; ++stone) {  // light and dark chippings, 2 to 7 cm
      const double contrast = random.chance(0.5) ? random.range(25, 75) : random.range(-60, -25);
      const double radius = random.range(0.0008, 0.0028);
      const double y = random.uniform();
      const double x = random.uniform();
      canvas.fillDisc(x, y, radius, kTone[kind] + static_cast<float>(contrast));
    }
    for (int crack = 0; crack < 14; ++crack) {
      double x = random.uniform();
      double y = random.uniform();
      double angle = random.range(0.0, 6.28);
      for (int step = 0; step < 140; ++step) {
        canvas.fillDisc(x, y, 0.0011, 34.0F);
        angle += random.range(-0.35, 0.35);
        x += 0.0014 * std::cos(angle);
        y += 0.0014 * std::sin(angle);
      }
    }
    const std::uint16_t added = add(canvas.texture());
    if (kind == 0) asphalt_ = added;
  }
  {
    HashStream random(hashOf(seed, 10));  // 8 x 8 slabs
    Canvas canvas(512, 150.0F);
    for (int row = 0; row < 8; ++row)
      for (int column = 0; column < 8; ++column)
        canvas.fillRect(column / 8.0, row / 8.0, (column + 1) / 8.0, (row + 1) / 8.0,
                        static_cast<float>(random.range(118, 178)));
    canvas.addNoise(32, 4, 18.0F, random.next(), 0.8F);
    for (int i = 0; i < 8; ++i) {
      canvas.fillRect(i / 8.0, 0.0, i / 8.0 + 0.008, 1.0, 70.0F);
      canvas.fillRect(0.0, i / 8.0, 1.0, i / 8.0 + 0.008, 70.0F);
    }
    pavement_ = add(canvas.texture());
  }
  {
    Canvas canvas(512, 88.0F);
    canvas.addNoise(8, 3, 22.0F, hashOf(seed, 11));
    canvas.addNoise(64, 4, 48.0F, hashOf(seed, 12), 0.8F);
    grass_ = add(canvas.texture());
  }
  {
    Canvas canvas(128, 168.0F);
    canvas.addNoise(16, 4, 26.0F, hashOf(seed, 13), 0.8F);
    canvas.fillRect(0.0, 0.0, 0.03, 1.0, 60.0F);
    kerb_ = add(canvas.texture());
  }
  {
    Canvas canvas(256, 215.0F);
    canvas.addNoise(8, 6, 40.0F, hashOf(seed, 14), 0.8F);
    marking_ = add(canvas.texture());
  }
  {
    Canvas canvas(128, 62.0F);
    canvas.fillDisc(0.5, 0.5, 0.46, 95.0F);
    canvas.fillDisc(0.5, 0.5, 0.40, 50.0F);
    for (int row = 0; row < 5; ++row)
      for (int column = 0; column < 5; ++column)
        canvas.fillRect(0.24 + 0.11 * column, 0.24 + 0.11 * row, 0.30 + 0.11 * column, 0.30 + 0.11 * row,
                        118.0F);
    canvas.addGrain(12.0F, hashOf(seed, 15));
    manhole_ = add(canvas.texture());
  }
  Canvas stains(512, 128.0F);
  stains.addNoise(4, 7, 62.0F, hashOf(seed, 16), 0.62F);
  stains_ = add(stains.texture());
}

void TextureLibrary::paintObjects(std::uint64_t seed) {
  for (int kind = 0; kind < kRoofs; ++kind) {
    HashStream random(hashOf(seed, static_cast<std::uint64_t>(kind)));
    const double tone = random.range(70, 120);
    Canvas canvas(256, static_cast<float>(tone));
    constexpr int kRows = 12;
    for (int row = 0; row < kRows; ++row) {
      const double y = static_cast<double>(row) / kRows;
      for (int tile = 0; tile < kRows; ++tile) {
        const double x = (tile + 0.5 * (row % 2)) / kRows;
        const auto bottom = static_cast<float>(tone + random.range(-22, 40));
        const auto top = static_cast<float>(tone + random.range(-22, 40));
        canvas.shadeRect(x, y, x + 1.0 / kRows, y + 1.0 / kRows, top, bottom, 0.0F);
        canvas.fillRect(x, y, x + 0.008, y + 1.0 / kRows, 45.0F);
      }
      canvas.fillRect(0.0, y, 1.0, y + 0.014, 38.0F);
    }
    canvas.addNoise(32, 4, 14.0F, random.next(), 0.8F);
    const std::uint16_t added = add(canvas.texture());
    if (kind == 0) roof_ = added;
  }
  for (int kind = 0; kind < kLeaves; ++kind) {
    HashStream random(hashOf(seed, 20, static_cast<std::uint64_t>(kind)));
    Canvas canvas(256, static_cast<float>(random.range(42, 62)));
    canvas.addNoise(4, 3, 18.0F, random.next());
    for (int leaf = 0; leaf < 2600; ++leaf) {
      const double tone = random.chance(0.3) ? random.range(8, 40) : random.range(55, 150);
      const double radius = random.range(0.004, 0.013);
      const double y = random.uniform();
      const double x = random.uniform();
      canvas.fillDisc(x, y, radius, static_cast<float>(tone));
    }
    const std::uint16_t added = add(canvas.texture());
    if (kind == 0) leaves_ = added;
  }
  constexpr float kPaint[kPaints] = {225.0F, 160.0F, 38.0F, 78.0F, 118.0F, 190.0F};
  for (int kind = 0; kind < kPaints; ++kind) {
    Canvas canvas(64, kPaint[kind]);
    canvas.shadeRect(0.0, 0.0, 1.0, 0.35, std::min(255.0F, kPaint[kind] + 45.0F), kPaint[kind], 0.0F);
    canvas.shadeRect(0.0, 0.35, 1.0, 1.0, kPaint[kind], kPaint[kind] * 0.7F, 0.0F);
    canvas.addNoise(8, 3, 5.0F, hashOf(seed, 30, static_cast<std::uint64_t>(kind)));
    const std::uint16_t added = add(canvas.texture());
    if (kind == 0) paint_ = added;
  }
  for (int kind = 0; kind < kSigns; ++kind) {  // rows of letter-like strokes
    HashStream random(hashOf(seed, 40, static_cast<std::uint64_t>(kind)));
    const bool dark = random.chance(0.5);
    const auto ground = static_cast<float>(dark ? random.range(25, 80) : random.range(170, 240));
    const auto ink = static_cast<float>(dark ? random.range(190, 245) : random.range(15, 70));
    Canvas canvas(128, ground);
    const int rows = 1 + random.index(3);
    for (int row = 0; row < rows; ++row) {
      const double y0 = (row + 0.2) / rows;
      const double y1 = (row + 0.8) / rows;
      for (double x = 0.06; x < 0.88;) {
        const double width = random.range(0.03, 0.10);
        const int strokes = random.index(4);
        if (strokes != 3) canvas.fillRect(x, y0, x + 0.022, y1, ink);
        if (strokes == 0) canvas.fillRect(x, y0, x + width, y0 + 0.2 * (y1 - y0), ink);
        if (strokes <= 1)
          canvas.fillRect(x, 0.5 * (y0 + y1) - 0.015, x + width, 0.5 * (y0 + y1) + 0.015, ink);
        if (strokes == 2) canvas.fillRect(x + width - 0.022, y0, x + width, y1, ink);
        x += width + 0.03;
      }
    }
    const std::uint16_t added = add(canvas.texture());
    if (kind == 0) sign_ = added;
  }
  {
    Canvas canvas(128, 70.0F);
    canvas.addNoise(16, 3, 40.0F, hashOf(seed, 50), 0.8F);
    for (int i = 0; i < 12; ++i) canvas.scaleRect(i / 12.0, 0.0, i / 12.0 + 0.03, 1.0, 0.5F);
    bark_ = add(canvas.texture());
  }
  {
    HashStream random(hashOf(seed, 51));
    Canvas canvas(256, 110.0F);
    for (int i = 0; i < 12; ++i)
      canvas.fillRect(i / 12.0, 0.0, (i + 1) / 12.0, 1.0, static_cast<float>(random.range(85, 165)));
    canvas.addNoise(32, 3, 16.0F, random.next());
    for (int i = 0; i < 12; ++i) canvas.fillRect(i / 12.0, 0.0, i / 12.0 + 0.012, 1.0, 30.0F);
    planks_ = add(canvas.texture());
  }
  Canvas plain(64, 128.0F);
  plain.addNoise(8, 3, 10.0F, hashOf(seed, 52));
  plain_ = add(plain.texture());
  Canvas glass(64, 50.0F);
  glass.shadeRect(0.0, 0.0, 1.0, 1.0, 130.0F, 28.0F, 0.0F);
  glass.fillRect(0.0, 0.0, 1.0, 0.06, 30.0F);
  glass.fillRect(0.0, 0.94, 1.0, 1.0, 30.0F);
  glass.fillRect(0.0, 0.0, 0.05, 1.0, 30.0F);
  glass.fillRect(0.95, 0.0, 1.0, 1.0, 30.0F);
  car_glass_ = add(glass.texture());
  for (const bool front : {true, false}) {
    Canvas canvas(128, front ? 150.0F : 120.0F);
    canvas.fillRect(0.04, 0.15, 0.24, 0.38, front ? 245.0F : 70.0F);
    canvas.fillRect(0.76, 0.15, 0.96, 0.38, front ? 245.0F : 70.0F);
    canvas.fillRect(0.10, 0.20, 0.18, 0.33, front ? 200.0F : 190.0F);
    canvas.fillRect(0.82, 0.20, 0.90, 0.33, front ? 200.0F : 190.0F);
    if (front) canvas.fillRect(0.30, 0.18, 0.70, 0.42, 30.0F);
    canvas.fillRect(0.36, 0.52, 0.64, 0.64, 235.0F);  // number plate
    for (int i = 0; i < 6; ++i) canvas.fillRect(0.39 + 0.04 * i, 0.545, 0.41 + 0.04 * i, 0.615, 20.0F);
    canvas.fillRect(0.0, 0.72, 1.0, 0.76, 50.0F);
    canvas.fillRect(0.0, 0.90, 1.0, 1.0, 25.0F);
    (front ? car_front_ : car_rear_) = add(canvas.texture());
  }
  Canvas wheel(64, 22.0F);
  wheel.fillDisc(0.5, 0.5, 0.30, 150.0F);
  for (int i = 0; i < 5; ++i)
    wheel.fillDisc(0.5 + 0.19 * std::cos(1.2566 * i), 0.5 + 0.19 * std::sin(1.2566 * i), 0.06, 40.0F);
  wheel.fillDisc(0.5, 0.5, 0.06, 70.0F);
  wheel_ = add(wheel.texture());
}

void TextureLibrary::paintSky(std::uint64_t seed) {
  Canvas clouds(1024, 205.0F);
  clouds.addNoise(4, 8, 62.0F, hashOf(seed, 1), 0.55F);
  clouds_ = add(clouds.texture());
  // A skyline for each side of a box round the beholder: elevation 0 at the lowest row, 45 degrees at the
  // top.
  for (int face = 0; face < kSkylines; ++face) {
    HashStream random(hashOf(seed, 2, static_cast<std::uint64_t>(face)));
    Canvas canvas(1024, 0.0F);
    const double phase = random.range(0.0, 6.28);
    for (int column = 0; column < 1024; ++column) {  // hills; their height is the same where two sides meet
      const double x = column / 1024.0;
      const double t = 6.283185307179586 * x;
      const double hill = 0.030 + 0.012 * (std::cos(t + phase) - std::cos(phase)) + 0.004 * std::sin(5.0 * t);
      canvas.fillRect(x, 1.0 - hill, x + 1.0 / 1024, 1.0,
                      static_cast<float>(128 + 12 * unitFromHash(random.next())));
    }
    for (int tower = 0; tower < 46; ++tower) {
      const double x = random.range(0.01, 0.95);
      const double width = random.range(0.008, 0.035);
      const double top = random.range(0.02, 0.065);
      const auto tone = static_cast<float>(random.range(95, 170));
      canvas.fillRect(x, 1.0 - top, x + width, 1.0, tone);
      for (double y = 0.006; y < top - 0.006; y += 0.008)
        for (double w = 0.003; w < width - 0.005; w += 0.006)
          if (random.chance(0.8))
            canvas.fillRect(x + w, 1.0 - top + y, x + w + 0.003, 1.0 - top + y + 0.004, tone - 45.0F);
    }
    const std::uint16_t added = add(canvas.texture());
    if (face == 0) skyline_ = added;
  }
}

}  // namespace ratslam
