#include "town/rasteriser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "ratslam/common/worker_pool.h"

namespace ratslam {
namespace {

constexpr int kTile = 32;  // [px]; visibility of a tile fits in the first-level cache
constexpr int kSamples = 4;
constexpr std::array<double, kSamples> kSampleX{-0.125, 0.375, -0.375, 0.125};
constexpr std::array<double, kSamples> kSampleY{-0.375, -0.125, 0.125, 0.375};
constexpr std::uint32_t kSky = 0xFFFFFFFF;
constexpr float kLayerLead = 0.002F;  // share of 1/depth by which a layer is ahead of the one below

/// The nearest surface at each sample of a tile.
struct Visibility {
  std::array<std::array<float, kTile * kTile>, kSamples> inverse_depth;
  std::array<std::array<std::uint32_t, kTile * kTile>, kSamples> surface;

  float farthest(int columns, int rows) const {
    float least = inverse_depth[0][0];
    for (const auto& plane : inverse_depth)
      for (int row = 0; row < rows; ++row) {
        const float* const begin = plane.data() + static_cast<std::size_t>(row * kTile);
        for (int column = 0; column < columns; ++column)
          least = begin[column] < least ? begin[column] : least;
        if (least == 0.0F) return least;
      }
    return least;
  }
};

int firstPixelAtOrAfter(double x) { return static_cast<int>(std::ceil(x)); }

struct Span {
  int begin, end;
};

/// Columns [begin, end) of one row of sample points that the outline covers.
Span coveredColumns(const ScreenTriangle& triangle, double sample_x, double y) {
  double low = 1e9;
  double high = -1e9;
  for (int i = 0; i < triangle.edge_count; ++i) {
    const ScreenTriangle::Edge& edge = triangle.edges[static_cast<std::size_t>(i)];
    if (y < edge.y_top || y >= edge.y_bottom) continue;
    const double x = edge.x_top + (y - edge.y_top) * edge.slope;
    low = std::min(low, x);
    high = std::max(high, x);
  }
  if (high <= low) return {0, 0};
  const double begin = std::max(low - sample_x, static_cast<double>(triangle.x_first));
  const double end = std::min(high - sample_x, static_cast<double>(triangle.x_last) + 1.0);
  return {firstPixelAtOrAfter(begin), firstPixelAtOrAfter(end)};
}

}  // namespace

struct Rasteriser::Tile {
  int x0, y0, x1, y1;  ///< pixels [x0,x1) x [y0,y1)
  std::vector<std::uint32_t> triangles;
};

Rasteriser::Rasteriser(const Shader& shader, const TownCamera& camera, int threads)
    : shader_(shader), camera_(camera), threads_(std::max(1, threads)) {}

RasterImage Rasteriser::draw(const std::vector<ScreenTriangle>& triangles,
                             const Eigen::Matrix3f& R_world_camera, bool with_depth) const {
  RasterImage image;
  image.grey.create(camera_.height, camera_.width, CV_32F);
  if (with_depth) image.inverse_depth.create(camera_.height, camera_.width, CV_32F);

  const int columns = (camera_.width + kTile - 1) / kTile;
  const int rows = (camera_.height + kTile - 1) / kTile;
  std::vector<Tile> tiles;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      tiles.push_back({column * kTile,
                       row * kTile,
                       std::min((column + 1) * kTile, camera_.width),
                       std::min((row + 1) * kTile, camera_.height),
                       {}});
  for (std::uint32_t i = 0; i < triangles.size(); ++i)
    for (int row = triangles[i].y_first / kTile; row <= triangles[i].y_last / kTile; ++row)
      for (int column = triangles[i].x_first / kTile; column <= triangles[i].x_last / kTile; ++column)
        tiles[static_cast<std::size_t>(row * columns + column)].triangles.push_back(i);

  WorkerPool(threads_).run(static_cast<int>(tiles.size()), [&](int i) {
    drawTile(tiles[static_cast<std::size_t>(i)], triangles, R_world_camera, image);
  });
  return image;
}

void Rasteriser::drawTile(Tile& tile, const std::vector<ScreenTriangle>& triangles,
                          const Eigen::Matrix3f& R_world_camera, RasterImage& image) const {
  const auto visibility = std::make_unique<Visibility>();
  for (auto& plane : visibility->inverse_depth) plane.fill(0.0F);
  for (auto& plane : visibility->surface) plane.fill(kSky);

  // Triangles come roughly from near to far: once a tile is filled, most of what follows is hidden as a
  // whole.
  float farthest = 0.0F;  // smallest 1/depth in the tile
  constexpr int kLookEvery = 48;
  int until_look = kLookEvery;
  for (const std::uint32_t number : tile.triangles) {
    const ScreenTriangle& triangle = triangles[number];
    const float lead = 1.0F + kLayerLead * static_cast<float>(triangle.layer);
    if (triangle.nearest * lead < farthest) continue;
    if (--until_look == 0) {
      farthest = visibility->farthest(tile.x1 - tile.x0, tile.y1 - tile.y0);
      until_look = kLookEvery;
    }
    const float slope = static_cast<float>(triangle.inverse_depth.x) * lead;
    const int y_end = std::min(tile.y1, triangle.y_last + 1);
    for (int row = std::max(tile.y0, triangle.y_first); row < y_end; ++row)
      for (std::size_t s = 0; s < kSamples; ++s) {
        const double y = row + kSampleY[s];
        const Span span = coveredColumns(triangle, kSampleX[s], y);
        const int begin = std::max(span.begin, tile.x0);
        const int end = std::min(span.end, tile.x1);
        if (begin >= end) continue;
        const auto start = static_cast<float>(triangle.inverse_depth.at(begin + kSampleX[s], y)) * lead;
        const auto offset = static_cast<std::size_t>((row - tile.y0) * kTile + begin - tile.x0);
        float* const nearest = visibility->inverse_depth[s].data() + offset;
        std::uint32_t* const surface = visibility->surface[s].data() + offset;
        for (int i = 0; i < end - begin; ++i) {
          const float here = start + static_cast<float>(i) * slope;
          const bool nearer = here > nearest[i];
          nearest[i] = nearer ? here : nearest[i];
          surface[i] = nearer ? number : surface[i];
        }
      }
  }

  const auto shade = [&](std::uint32_t number, double x, double y) {
    return number == kSky ? shader_.sky(R_world_camera * shader_.ray(x, y))
                          : shader_.surface(triangles[number], x, y);
  };
  for (int row = tile.y0; row < tile.y1; ++row) {
    float* const out = image.grey.ptr<float>(row);
    for (int column = tile.x0; column < tile.x1; ++column) {
      const auto offset = static_cast<std::size_t>((row - tile.y0) * kTile + column - tile.x0);
      std::array<std::uint32_t, kSamples> seen;
      for (std::size_t s = 0; s < kSamples; ++s) seen[s] = visibility->surface[s][offset];
      if (seen[0] == seen[1] && seen[0] == seen[2] && seen[0] == seen[3]) {
        out[column] = shade(seen[0], column, row);
      } else {
        float sum = 0.0F;
        for (std::size_t s = 0; s < kSamples; ++s) {
          double x = 0.0;
          double y = 0.0;
          int count = 0;
          for (std::size_t t = 0; t < kSamples; ++t) {
            if (seen[t] != seen[s]) continue;
            if (t < s) break;  // this surface has been shaded
            x += kSampleX[t];
            y += kSampleY[t];
            ++count;
          }
          if (count > 0)
            sum += static_cast<float>(count) * shade(seen[s], column + x / count, row + y / count);
        }
        out[column] = sum / kSamples;
      }
      if (!image.inverse_depth.empty()) {
        float nearest = 0.0F;
        for (std::size_t s = 0; s < kSamples; ++s)
          nearest = std::max(nearest, visibility->inverse_depth[s][offset]);
        image.inverse_depth.at<float>(row, column) = nearest;
      }
    }
  }
}

}  // namespace ratslam
