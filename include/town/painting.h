/// Tools for painting textures: a repeating canvas, value noise (summed over octaves), rectangles and discs.
#pragma once

#include <cstdint>
#include <vector>

#include "town/texture.h"

namespace ratslam {

/// A square grey picture in float, values nominally in [0,255]; coordinates in [0,1), x right, y down,
/// repeating.
class Canvas {
 public:
  Canvas(int size, float value);
  int size() const { return size_; }
  float& at(int column, int row) { return texels_[index(column, row)]; }
  float at(int column, int row) const { return texels_[index(column, row)]; }

  /// Adds value noise of about +-amplitude: octaves of `cells`, 2 cells, 4 cells ... squares per side, each
  /// half as strong as the one before (gain 0.5) or as `gain` says.
  void addNoise(int cells, int octaves, float amplitude, std::uint64_t seed, float gain = 0.5F);
  /// Adds to each texel noise of +-amplitude that no neighbour shares.
  void addGrain(float amplitude, std::uint64_t seed);
  /// Sets a rectangle to a value; edges fall on texels.
  void fillRect(double x0, double y0, double x1, double y1, float value);
  /// Blends a rectangle vertically from one value (top) to another (bottom), leaving `keep` of what was
  /// there.
  void shadeRect(double x0, double y0, double x1, double y1, float top, float bottom, float keep);
  void fillDisc(double x, double y, double radius, float value);
  /// Multiplies a rectangle.
  void scaleRect(double x0, double y0, double x1, double y1, float factor);
  Texture texture() const { return {size_, texels_}; }

 private:
  std::size_t index(int column, int row) const {
    const int mask = size_ - 1;
    return static_cast<std::size_t>((row & mask) * size_ + (column & mask));
  }
  int texel(double x) const;

  int size_;
  std::vector<float> texels_;
};

}  // namespace ratslam
