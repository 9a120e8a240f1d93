#include "town/texture.h"

#include <algorithm>

#include "ratslam/common/params.h"

namespace ratslam {

Texture::Texture(int size, const std::vector<float>& texels) : size_(size) {
  if (size < 1 || (size & (size - 1)) != 0) throwBadValue("texture size", size, "it must be a power of two");
  if (texels.size() != static_cast<std::size_t>(size) * static_cast<std::size_t>(size))
    throwBadValue("texture texels", texels.size(), "there must be size * size of them");
  std::vector<float> level = texels;
  for (int edge = size;; edge /= 2) {
    offsets_.push_back(texels_.size());
    for (const float value : level)
      texels_.push_back(static_cast<std::uint8_t>(std::clamp(value, 0.0F, 255.0F) + 0.5F));
    if (edge == 1) break;
    const auto half = static_cast<std::size_t>(edge / 2);
    std::vector<float> next(half * half);
    for (std::size_t y = 0; y < half; ++y)
      for (std::size_t x = 0; x < half; ++x) {
        const float* const upper = &level[2 * y * 2 * half + 2 * x];
        const float* const lower = upper + 2 * half;
        next[y * half + x] = 0.25F * (upper[0] + upper[1] + lower[0] + lower[1]);
      }
    level = std::move(next);
  }
}

}  // namespace ratslam
