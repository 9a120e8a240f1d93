#include <algorithm>

#include "town/hash.h"
#include "town/painting.h"
#include "town/texture_library.h"

namespace ratslam {
namespace {

constexpr int kSize = 256;  // texels a bay, 1.2 cm each

/// Courses of stones, `rows` of them, every other one shifted by half a stone.
void layStones(Canvas& canvas, int rows, int columns, double tone, double spread, float joint,
               HashStream& random) {
  const double joint_width = 1.2 / kSize;
  for (int row = 0; row < rows; ++row) {
    const double y0 = static_cast<double>(row) / rows;
    const double y1 = static_cast<double>(row + 1) / rows;
    for (int column = 0; column < columns; ++column) {
      const double x = (column + 0.5 * (row % 2)) / columns;
      canvas.fillRect(x, y0, x + 1.0 / columns, y1, static_cast<float>(tone + random.range(-spread, spread)));
      canvas.fillRect(x, y0, x + joint_width, y1, joint);
    }
    canvas.fillRect(0.0, y0, 1.0, y0 + joint_width, joint);
  }
}

Canvas paintBareWall(int wall, HashStream& random) {
  const double tone = random.range(95, 190);
  Canvas canvas(kSize, static_cast<float>(tone));
  switch (wall % 5) {
    case 0:  // brick
      layStones(canvas, 32, 12, tone - 20, 38, static_cast<float>(random.chance(0.5) ? tone + 55 : tone - 70),
                random);
      canvas.addNoise(16, 4, 10.0F, random.next());
      break;
    case 1:  // rough plaster, cracked and patched
      canvas.addNoise(4, 3, 14.0F, random.next());
      canvas.addNoise(32, 3, 26.0F, random.next(), 0.9F);
      for (int patch = 0; patch < 5; ++patch) {
        const double x = random.uniform();
        const double y = random.uniform();
        const auto factor = static_cast<float>(random.range(0.72, 1.2));
        const double height = random.range(0.05, 0.15);
        const double width = random.range(0.05, 0.2);
        canvas.scaleRect(x, y, x + width, y + height, factor);
      }
      break;
    case 2:  // ashlar
      layStones(canvas, 8, 4, tone, 30, static_cast<float>(tone - 65), random);
      canvas.addNoise(32, 4, 18.0F, random.next(), 0.8F);
      break;
    case 3:  // boards
      for (int row = 0; row < 16; ++row) {
        const auto board = static_cast<float>(tone + random.range(-16, 16));
        canvas.shadeRect(0.0, row / 16.0, 1.0, (row + 1) / 16.0, board - 25.0F, board + 12.0F, 0.0F);
        canvas.fillRect(0.0, row / 16.0, 1.0, row / 16.0 + 0.008, 45.0F);
        const double joint = random.uniform();
        canvas.fillRect(joint, row / 16.0, joint + 0.01, (row + 1) / 16.0, 50.0F);
      }
      canvas.addNoise(32, 3, 12.0F, random.next());
      break;
    default:  // large panels
      layStones(canvas, 4, 2, tone, 22, static_cast<float>(tone - 60), random);
      canvas.addNoise(64, 2, 16.0F, random.next(), 0.9F);
      break;
  }
  return canvas;
}

struct WindowStyle {
  double half_width, top, bottom, frame;
  int mullions, transoms;
  bool sill, lintel, shutters;
  float frame_tone, trim_tone;
};

WindowStyle drawStyle(HashStream& random) {
  WindowStyle style{};
  style.half_width = random.range(0.16, 0.27);
  style.top = random.range(0.16, 0.24);
  style.bottom = random.range(0.64, 0.74);
  style.frame = random.range(0.014, 0.026);
  style.mullions = 1 + random.index(3);
  style.transoms = random.index(3);
  style.sill = random.chance(0.8);
  style.lintel = random.chance(0.6);
  style.shutters = style.half_width < 0.21 && random.chance(0.6);
  style.frame_tone = static_cast<float>(random.chance(0.7) ? random.range(205, 245) : random.range(30, 70));
  style.trim_tone = static_cast<float>(random.chance(0.6) ? random.range(190, 235) : random.range(50, 95));
  return style;
}

/// Panes between frame bars, dark with a reflection of the sky, some with curtains or blinds.
void glaze(Canvas& canvas, double x0, double y0, double x1, double y1, const WindowStyle& style,
           HashStream& random) {
  canvas.fillRect(x0, y0, x1, y1, style.frame_tone);
  const int columns = style.mullions + 1;
  const int rows = style.transoms + 1;
  const double reflection = random.range(70, 130);
  const int inside = random.index(4);  // nothing, curtains, a blind, a lamp
  const double pane_width = (x1 - x0 - style.frame) / columns;
  const double pane_height = (y1 - y0 - style.frame) / rows;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const double px = x0 + style.frame + column * pane_width;
      const double py = y0 + style.frame + row * pane_height;
      const double right = px + pane_width - style.frame;
      const double bottom = py + pane_height - style.frame;
      const auto top_tone = static_cast<float>(reflection * random.range(0.8, 1.2) / (1 + row));
      canvas.shadeRect(px, py, right, bottom, top_tone, 22.0F, 0.0F);
      if (inside == 1 && (column == 0 || column == columns - 1))
        canvas.shadeRect(px, py, px + 0.6 * pane_width, bottom, 175.0F, 140.0F, 0.15F);
      if (inside == 2 && row == 0)
        for (double y = py; y < py + 0.6 * (bottom - py); y += 0.02)
          canvas.fillRect(px, y, right, y + 0.012, 165.0F);
      if (inside == 3 && column == 0) canvas.fillDisc(0.5 * (px + right), 0.5 * (py + bottom), 0.02, 230.0F);
    }
}

void addWindow(Canvas& canvas, WindowStyle style, HashStream& random) {
  const double x0 = 0.5 - style.half_width;
  const double x1 = 0.5 + style.half_width;
  const double trim = 0.024;
  if (style.lintel)
    canvas.fillRect(x0 - 0.03, style.top - 0.055, x1 + 0.03, style.top - trim, style.trim_tone);
  canvas.fillRect(x0 - trim, style.top - trim, x1 + trim, style.bottom + 0.5 * trim, style.trim_tone);
  glaze(canvas, x0, style.top, x1, style.bottom, style, random);
  canvas.scaleRect(x0, style.top, x1, style.top + 0.016, 0.45F);  // the reveal's shadow
  if (style.sill) {
    canvas.fillRect(x0 - 0.04, style.bottom, x1 + 0.04, style.bottom + 0.025,
                    std::min(250.0F, style.trim_tone + 30.0F));
    canvas.scaleRect(x0 - 0.04, style.bottom + 0.025, x1 + 0.04, style.bottom + 0.05, 0.5F);
    if (random.chance(0.35))  // flowers
      for (int i = 0; i < 60; ++i) {
        const auto tone = static_cast<float>(random.range(30, 220));
        const double radius = random.range(0.005, 0.012);
        const double y = style.bottom - random.range(0.0, 0.05);
        const double x = random.range(x0, x1);
        canvas.fillDisc(x, y, radius, tone);
      }
  }
  if (style.shutters) {
    const auto tone = static_cast<float>(random.range(45, 120));
    for (const double left : {x0 - trim - 0.12, x1 + trim}) {
      canvas.fillRect(left, style.top, left + 0.12, style.bottom, tone);
      for (double y = style.top + 0.02; y < style.bottom - 0.02; y += 0.028)
        canvas.fillRect(left + 0.015, y, left + 0.105, y + 0.012, tone * 0.5F);
    }
  }
}

void addDoor(Canvas& canvas, HashStream& random) {
  const double half = random.range(0.16, 0.22);
  const auto tone = static_cast<float>(random.chance(0.5) ? random.range(35, 80) : random.range(120, 200));
  canvas.fillRect(0.5 - half - 0.05, 0.14, 0.5 + half + 0.05, 1.0,
                  static_cast<float>(random.range(170, 225)));
  canvas.fillRect(0.5 - half, 0.19, 0.5 + half, 1.0, 28.0F);
  canvas.shadeRect(0.5 - half + 0.01, 0.20, 0.5 + half - 0.01, 0.30, 120.0F, 50.0F, 0.0F);
  canvas.fillRect(0.5 - half + 0.012, 0.315, 0.5 + half - 0.012, 0.97, tone);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 2; ++column) {
      const double x = 0.5 - half + 0.03 + column * (half - 0.015);
      const double y = 0.35 + 0.2 * row;
      canvas.fillRect(x, y, x + half - 0.045, y + 0.16, tone * 0.68F);
      canvas.fillRect(x + 0.012, y + 0.012, x + half - 0.057, y + 0.148, std::min(255.0F, tone * 1.12F));
    }
  canvas.fillDisc(0.5 + 0.75 * half, 0.66, 0.014, 235.0F);
  canvas.fillRect(0.5 - half - 0.08, 0.965, 0.5 + half + 0.08, 1.0, 165.0F);
  canvas.fillRect(0.80, 0.42, 0.86, 0.47, 215.0F);  // house number
  canvas.fillRect(0.815, 0.43, 0.825, 0.46, 30.0F);
  canvas.fillRect(0.835, 0.43, 0.850, 0.46, 30.0F);
}

void addShop(Canvas& canvas, HashStream& random) {
  WindowStyle style = drawStyle(random);
  style.transoms = 0;
  style.mullions = random.index(2);
  canvas.fillRect(0.0, 0.04, 1.0, 0.22,
                  static_cast<float>(random.range(40, 215)));  // the board a sign hangs on
  canvas.fillRect(0.0, 0.22, 1.0, 0.235, 30.0F);
  glaze(canvas, 0.05, 0.26, 0.95, 0.86, style, random);
  for (int item = 0; item < 16; ++item) {  // the display
    const double x = random.range(0.08, 0.84);
    const double width = random.range(0.03, 0.09);
    const double y = 0.85 - random.range(0.05, 0.25);
    const auto tone = static_cast<float>(random.range(60, 230));
    canvas.fillRect(x, y, x + width, 0.85, tone);
    canvas.fillRect(x + 0.2 * width, y + 0.02, x + 0.6 * width, y + 0.04, 255.0F - tone);
  }
  canvas.scaleRect(0.0, 0.92, 1.0, 1.0, 0.6F);
}

}  // namespace

void TextureLibrary::paintWalls(std::uint64_t seed) {
  for (int wall = 0; wall < kWalls; ++wall) {
    HashStream random(hashOf(seed, static_cast<std::uint64_t>(wall)));
    const Canvas bare = paintBareWall(wall, random);
    const std::uint16_t first = add(bare.texture());
    if (wall == 0) walls_ = first;
    const WindowStyle style = drawStyle(random);
    for (int kind = 0; kind < kWindows; ++kind) {
      Canvas canvas = bare;
      addWindow(canvas, kind < kWindows - 1 ? style : drawStyle(random), random);
      canvas.addNoise(32, 2, 5.0F, random.next());
      add(canvas.texture());
    }
    for (int kind = 0; kind < kDoors; ++kind) {
      Canvas canvas = bare;
      addDoor(canvas, random);
      add(canvas.texture());
    }
    for (int kind = 0; kind < kShops; ++kind) {
      Canvas canvas = bare;
      addShop(canvas, random);
      add(canvas.texture());
    }
  }
}

}  // namespace ratslam
