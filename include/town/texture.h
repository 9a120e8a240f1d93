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
  /// @throws std::invalid_argument if the size is no power of two or does not fit the texels.
  Texture(int size, const std::vector<float>& texels);

  int size() const { return size_; }
  /// Largest level of detail: there the texture is a single texel.
  float maxLod() const { return static_cast<float>(offsets_.size() - 1); }

  /// Filtered value in [0,255] at (u, v) [repeats]; lod 0 is full resolution, each level halves it.
  /// |u| and |v| times the size must stay below 2^23: positions count in 1/256 texel.
  float sample(float u, float v, float lod) const {
    if (!(lod > 0.0F)) return sampleLevel(u, v, 0);
    const float limit = maxLod();
    if (lod >= limit) return static_cast<float>(texels_.back());
    const int level = static_cast<int>(lod);
    const auto size = static_cast<float>(size_);
    const int x = static_cast<int>(u * (256.0F * size));
    const int y = static_cast<int>(v * (256.0F * size));
    const int share = static_cast<int>((lod - static_cast<float>(level)) * 256.0F);
    const int fine = bilinear(x >> level, y >> level, level);
    const int coarse = bilinear(x >> (level + 1), y >> (level + 1), level + 1);
    return static_cast<float>(fine + share * ((coarse - fine) >> 8)) * kUnit;
  }
  /// Bilinear value in one level, which must be at most maxLod().
  float sampleLevel(float u, float v, int level) const {
    const auto size = static_cast<float>(size_ >> level);
    return static_cast<float>(bilinear(static_cast<int>(u * (256.0F * size)),
                                       static_cast<int>(v * (256.0F * size)), level)) *
           kUnit;
  }

 private:
  static constexpr float kUnit = 1.0F / 65536.0F;

  /// Value times 2^16 at a position in 1/256 texel of a level.
  int bilinear(int x, int y, int level) const {
    const int mask = (size_ >> level) - 1;
    const int column = (x - 128) >> 8;
    const int row = (y - 128) >> 8;
    const int fx = (x - 128) & 255;
    const int fy = (y - 128) & 255;
    const std::uint8_t* const texels = texels_.data() + offsets_[static_cast<std::size_t>(level)];
    const std::uint8_t* const row0 = texels + (row & mask) * (mask + 1);
    const std::uint8_t* const row1 = texels + ((row + 1) & mask) * (mask + 1);
    const int x0 = column & mask;
    const int x1 = (column + 1) & mask;
    const int top = (row0[x0] << 8) + fx * (row0[x1] - row0[x0]);
    const int bottom = (row1[x0] << 8) + fx * (row1[x1] - row1[x0]);
    return (top << 8) + fy * (bottom - top);
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
