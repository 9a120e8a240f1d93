/// A square grey texture that repeats, with its mip-map pyramid and trilinear filter (Williams, SIGGRAPH
/// 1983).
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace ratslam {

class Texture {
 public:
  Texture() = default;
  /// @param size edge [texels], a power of two; @param texels size*size values in [0,255], clamped, row by
  /// row.
  /// @throws std::invalid_argument where the size is no power of two or does not fit the texels.
  Texture(int size, const std::vector<float>& texels);

  int size() const { return size_; }
  /// Largest level of detail: there the texture is a single texel.
  float maxLod() const { return static_cast<float>(offsets_.size() - 1); }

  /// Filtered value in [0,255] at (u, v) [repeats]; lod 0 is full resolution, each level halves it.
  float sample(float u, float v, float lod) const {
    if (!(lod > 0.0F)) return bilinear(u, v, 0);
    const float limit = maxLod();
    if (lod >= limit) return texels_.back();
    const int level = static_cast<int>(lod);
    const float fraction = lod - static_cast<float>(level);
    const float fine = bilinear(u, v, level);
    return fine + fraction * (bilinear(u, v, level + 1) - fine);
  }

 private:
  static int floorToInt(float x) {
    const int truncated = static_cast<int>(x);
    return truncated - static_cast<int>(x < static_cast<float>(truncated));
  }
  float bilinear(float u, float v, int level) const {
    const int size = size_ >> level;
    const int mask = size - 1;
    const std::uint8_t* const texels = texels_.data() + offsets_[static_cast<std::size_t>(level)];
    const float x = u * static_cast<float>(size) - 0.5F;
    const float y = v * static_cast<float>(size) - 0.5F;
    const int x_floor = floorToInt(x);
    const int y_floor = floorToInt(y);
    const float fx = x - static_cast<float>(x_floor);
    const float fy = y - static_cast<float>(y_floor);
    const int x0 = x_floor & mask;
    const int x1 = (x_floor + 1) & mask;
    const std::uint8_t* const row0 = texels + (y_floor & mask) * size;
    const std::uint8_t* const row1 = texels + ((y_floor + 1) & mask) * size;
    const float top = static_cast<float>(row0[x0]) + fx * static_cast<float>(row0[x1] - row0[x0]);
    const float bottom = static_cast<float>(row1[x0]) + fx * static_cast<float>(row1[x1] - row1[x0]);
    return top + fy * (bottom - top);
  }

  int size_ = 0;
  std::vector<std::size_t> offsets_;  ///< of each level in texels_
  std::vector<std::uint8_t> texels_;
};

/// log2 of a positive number, off by at most 0.09 (linear within an octave): the same on every machine.
inline float roughLog2(float x) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  return static_cast<float>(bits) * (1.0F / 8388608.0F) - 127.0F;
}

}  // namespace ratslam
