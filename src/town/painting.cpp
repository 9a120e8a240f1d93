#include "town/painting.h"

#include <cmath>

#include "town/hash.h"

namespace ratslam {

Canvas::Canvas(int size, float value)
    : size_(size), texels_(static_cast<std::size_t>(size) * static_cast<std::size_t>(size), value) {}

int Canvas::texel(double x) const { return static_cast<int>(std::lround(x * size_)); }

void Canvas::addNoise(int cells, int octaves, float amplitude, std::uint64_t seed, float gain) {
  std::vector<float> lattice;
  for (int octave = 0; octave < octaves && cells <= size_; ++octave, cells *= 2, amplitude *= gain) {
    const auto n = static_cast<std::size_t>(cells);
    lattice.resize(n * n);
    const std::uint64_t octave_seed = hashOf(seed, static_cast<std::uint64_t>(octave));
    double mean = 0.0;
    for (std::size_t i = 0; i < lattice.size(); ++i) mean += unitFromHash(hashOf(octave_seed, i));
    mean /= static_cast<double>(lattice.size());
    for (std::size_t i = 0; i < lattice.size(); ++i)
      lattice[i] = 2.0F * amplitude * static_cast<float>(unitFromHash(hashOf(octave_seed, i)) - mean);
    const auto step = static_cast<std::size_t>(size_ / cells);
    std::vector<float> weight(step);  // of the right, or lower, lattice point
    for (std::size_t i = 0; i < step; ++i) {
      const float t = static_cast<float>(i) / static_cast<float>(step);
      weight[i] = t * t * (3.0F - 2.0F * t);
    }
    float* texel = texels_.data();
    for (std::size_t row = 0; row < static_cast<std::size_t>(size_); ++row) {
      const float* const top = &lattice[row / step * n];
      const float* const bottom = &lattice[(row / step + 1) % n * n];
      const float fy = weight[row % step];
      for (std::size_t cell = 0; cell < n; ++cell) {
        const std::size_t right = (cell + 1) % n;
        const float from = top[cell] + fy * (bottom[cell] - top[cell]);
        const float to = top[right] + fy * (bottom[right] - top[right]);
        for (std::size_t i = 0; i < step; ++i) *texel++ += from + weight[i] * (to - from);
      }
    }
  }
}

void Canvas::addGrain(float amplitude, std::uint64_t seed) {
  for (std::size_t i = 0; i < texels_.size(); ++i)
    texels_[i] += amplitude * static_cast<float>(2.0 * unitFromHash(hashOf(seed, i)) - 1.0);
}

void Canvas::fillRect(double x0, double y0, double x1, double y1, float value) {
  for (int row = texel(y0); row < texel(y1); ++row)
    for (int column = texel(x0); column < texel(x1); ++column) at(column, row) = value;
}

void Canvas::shadeRect(double x0, double y0, double x1, double y1, float top, float bottom, float keep) {
  const int first = texel(y0);
  const int last = texel(y1);
  for (int row = first; row < last; ++row) {
    const float t = static_cast<float>(row - first) / static_cast<float>(last - first);
    const float value = (1.0F - keep) * (top + t * (bottom - top));
    for (int column = texel(x0); column < texel(x1); ++column)
      at(column, row) = keep * at(column, row) + value;
  }
}

void Canvas::fillDisc(double x, double y, double radius, float value) {
  const double r = radius * size_;
  const double cx = x * size_;
  const double cy = y * size_;
  for (int row = static_cast<int>(std::floor(cy - r)); row <= static_cast<int>(std::ceil(cy + r)); ++row)
    for (int column = static_cast<int>(std::floor(cx - r)); column <= static_cast<int>(std::ceil(cx + r));
         ++column)
      if (std::hypot(column + 0.5 - cx, row + 0.5 - cy) < r) at(column, row) = value;
}

void Canvas::scaleRect(double x0, double y0, double x1, double y1, float factor) {
  for (int row = texel(y0); row < texel(y1); ++row)
    for (int column = texel(x0); column < texel(x1); ++column) at(column, row) *= factor;
}

}  // namespace ratslam
