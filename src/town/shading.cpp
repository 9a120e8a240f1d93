#include "town/shading.h"

#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

constexpr float kHaze = 205.0F;      // grey value of the haze, and of the sky at the horizon
constexpr float kHazeStep = 2.0F;    // [m]
constexpr float kMaxSamples = 8.0F;  // along the longer axis of a pixel's footprint

/// Average of a texture over a pixel's footprint, spanned by the steps to the next column and row [repeats].
float sampleFootprint(const Texture& texture, float u, float v, const Eigen::Vector2f& across,
                      const Eigen::Vector2f& down) {
  const auto size = static_cast<float>(texture.size());
  const float across_squared = across.squaredNorm();
  const float down_squared = down.squaredNorm();
  const bool across_longer = across_squared > down_squared;
  const Eigen::Vector2f& axis = across_longer ? across : down;
  const float longer = std::sqrt(across_longer ? across_squared : down_squared) * size;
  // The footprint is a parallelogram: its area over the longer side is its width.
  const float area = std::abs(across.x() * down.y() - across.y() * down.x()) * size * size;
  const float width = std::max(area / std::max(longer, 1e-12F), longer / kMaxSamples);
  if (longer <= 1.0F) return texture.sample(u, v, 0.0F);
  const int samples =
      static_cast<int>(std::ceil(std::min(longer / std::max(width, 1.0F), kMaxSamples) - 0.25F));
  const float lod = roughLog2(std::max({width, longer / kMaxSamples, 1.0F}));
  if (samples <= 1) return texture.sample(u, v, lod);
  const float step = 1.0F / static_cast<float>(samples);
  float sum = 0.0F;
  // Every other sample goes up a level half a level later: as smooth as trilinear ones at half the cost.
  const int levels[2] = {static_cast<int>(std::min(lod + 0.25F, texture.maxLod())),
                         static_cast<int>(std::min(lod + 0.75F, texture.maxLod()))};
  for (int i = 0; i < samples; ++i) {
    const float t = (static_cast<float>(i) + 0.5F) * step - 0.5F;
    sum += texture.sampleLevel(u + t * axis.x(), v + t * axis.y(), levels[i % 2]);
  }
  return sum * step;
}

}  // namespace

Shader::Shader(const TextureLibrary& textures, const TownCamera& camera)
    : textures_(textures), camera_(camera) {
  for (float distance = 0.0F; distance <= static_cast<float>(kViewDistance) + 2.0F * kHazeStep;
       distance += kHazeStep) {
    const float clear_air = std::exp(-distance * distance / (2.0F * 150.0F * 150.0F));
    const auto view = static_cast<float>(kViewDistance);
    const float fade = std::clamp((view - distance) / (0.3F * view), 0.0F, 1.0F);
    haze_.push_back(1.0F - clear_air * fade);
  }
}

float Shader::hazeAt(float distance) const {
  const float cell = std::min(distance / kHazeStep, static_cast<float>(haze_.size()) - 1.001F);
  const auto i = static_cast<std::size_t>(cell);
  return haze_[i] + (cell - static_cast<float>(i)) * (haze_[i + 1] - haze_[i]);
}

float Shader::surface(const ScreenTriangle& triangle, double x, double y) const {
  // Just outside a grazing outline 1/depth may come near zero: never farther than twice the view.
  const double inverse_depth = std::max(triangle.inverse_depth.at(x, y), 0.5 / kViewDistance);
  const double depth = 1.0 / inverse_depth;
  const double u = triangle.u.at(x, y) * depth;
  const double v = triangle.v.at(x, y) * depth;
  const auto light = static_cast<float>(triangle.light.at(x, y) * depth);
  const Eigen::Vector2f across{static_cast<float>((triangle.u.x - u * triangle.inverse_depth.x) * depth),
                               static_cast<float>((triangle.v.x - v * triangle.inverse_depth.x) * depth)};
  const Eigen::Vector2f down{static_cast<float>((triangle.u.y - u * triangle.inverse_depth.y) * depth),
                             static_cast<float>((triangle.v.y - v * triangle.inverse_depth.y) * depth)};
  // Textures repeat: whole repeats carry no information, but cost precision.
  const auto uf = static_cast<float>(u - std::floor(u));
  const auto vf = static_cast<float>(v - std::floor(v));
  float value = sampleFootprint(textures_[triangle.texture], uf, vf, across, down) * light;
  if (triangle.stain_scale > 0.0F) {
    const Texture& stains = textures_[textures_.stains()];
    const float reach = triangle.stain_scale * static_cast<float>(stains.size());
    const float footprint = reach * reach * std::max(across.squaredNorm(), down.squaredNorm());
    const float stain =
        stains.sample(static_cast<float>(u) * triangle.stain_scale + triangle.stain_offset.x(),
                      static_cast<float>(v) * triangle.stain_scale + triangle.stain_offset.y(),
                      0.5F * roughLog2(std::max(footprint, 1.0F)));
    value *= 0.45F + stain * (0.55F / 128.0F);
  }
  const float haze = hazeAt(static_cast<float>(depth) * ray(x, y).norm());
  return value + haze * (kHaze - value);
}

float Shader::sky(const Eigen::Vector3f& direction) const {
  const float east = direction.x();
  const float north = direction.z();
  const float up = -direction.y();
  const bool along_z = std::abs(north) >= std::abs(east);
  const float reach = std::max(std::abs(north), std::abs(east));
  const float elevation = up / std::max(reach, 1e-6F);
  // Below the horizon: distant land that fades away downwards.
  constexpr float kLand = 163.0F;
  float value = kHaze + (kLand - kHaze) * std::clamp(1.0F + elevation / 0.08F, 0.0F, 1.0F);
  if (elevation > 0.0F) {
    value = kHaze;
    const float pixel = 1.0F / static_cast<float>(camera_.fx);
    constexpr float kCloudScale = 0.10F;
    const float layer = kCloudScale / std::max(up, 1e-4F);
    const Texture& clouds = textures_[textures_.clouds()];
    const float slant = up / direction.norm();
    const float footprint = kCloudScale * pixel / (slant * slant) * static_cast<float>(clouds.size());
    const float cloud = clouds.sample(east * layer, north * layer, roughLog2(std::max(footprint, 1.0F)));
    const float clear = std::clamp((elevation - 0.02F) / 0.25F, 0.0F, 1.0F);
    value += clear * (cloud - value);
    if (elevation < 0.1F) {
      const bool positive = (along_z ? north : east) >= 0.0F;
      const int face = (along_z ? 0 : 1) + (positive ? 0 : 2);
      const float side = (along_z ? east : north) / reach;
      const Texture& skyline = textures_[textures_.skyline(face)];
      const float texels = 0.5F * static_cast<float>(skyline.size()) * pixel;
      const float tone =
          skyline.sample(0.5F * side + 0.5F, 1.0F - elevation, roughLog2(std::max(texels, 1.0F)));
      // The texture is 0 where there is sky and at least 80 where there is not: less is an edge's share.
      const float cover = std::min(tone / 80.0F, 1.0F);
      value = value * (1.0F - cover) + cover * (0.45F * kHaze) + 0.55F * tone;
    }
  }
  return std::min(value, 255.0F);
}

}  // namespace ratslam
