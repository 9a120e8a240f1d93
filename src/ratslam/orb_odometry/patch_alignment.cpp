#include "ratslam/orb_odometry/patch_alignment.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace ratslam {
namespace {

constexpr int kSize = 10;        // edge of the patch [px of the level]
constexpr int kRim = kSize + 2;  // with the border that central differences need
constexpr int kArea = kSize * kSize;
constexpr int kMaxIterations = 10;
constexpr float kConverged = 0.01F;  // [px of the level]
constexpr float kMinVariance =
    9.0F;  // of the template's grey values: below, there is nothing but noise to align

// Fixed-size arrays of Eigen: sums run in vector registers, in an order fixed at compile time.
using Patch = Eigen::Array<float, kArea, 1>;

struct Template {
  Patch value;  // mean taken off, like both gradients
  Patch gradient_x;
  Patch gradient_y;
  float energy = 0.0F;            // sum of squares of value
  float value_gradient_x = 0.0F;  // sum of value times gradient
  float value_gradient_y = 0.0F;
  Eigen::Matrix2f inverse_hessian;
};

float bilinear(const cv::Mat& image, float x, float y) {
  const int column = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const float fx = x - static_cast<float>(column);
  const float fy = y - static_cast<float>(row);
  const uchar* upper = image.ptr<uchar>(row) + column;
  const uchar* lower = image.ptr<uchar>(row + 1) + column;
  return (1.0F - fy) * ((1.0F - fx) * upper[0] + fx * upper[1]) +
         fy * ((1.0F - fx) * lower[0] + fx * lower[1]);
}

/// Samples the source image so that the template looks as the target level should.
/// @param step source-level pixels per target-level pixel.
bool makeTemplate(const cv::Mat& image, const Eigen::Vector2d& centre, const Eigen::Matrix2d& step,
                  Template& patch) {
  constexpr double kMiddle = 0.5 * (kRim - 1);
  const Eigen::Vector2d reach = kMiddle * step.cwiseAbs().rowwise().sum();
  if (!((centre - reach).minCoeff() >= 0.0) || !(centre.x() + reach.x() < image.cols - 1) ||
      !(centre.y() + reach.y() < image.rows - 1)) {
    return false;
  }
  std::array<float, kRim * kRim> rim;
  const Eigen::Matrix2f m = step.cast<float>();
  const Eigen::Vector2f corner = (centre - step * Eigen::Vector2d(kMiddle, kMiddle)).cast<float>();
  for (int v = 0; v < kRim; ++v) {
    for (int u = 0; u < kRim; ++u) {
      const Eigen::Vector2f at = corner + m * Eigen::Vector2f(static_cast<float>(u), static_cast<float>(v));
      rim[static_cast<std::size_t>(v * kRim + u)] = bilinear(image, at.x(), at.y());
    }
  }
  for (int v = 0; v < kSize; ++v) {
    for (int u = 0; u < kSize; ++u) {
      const int i = v * kSize + u;
      const float* at = &rim[static_cast<std::size_t>((v + 1) * kRim + u + 1)];
      patch.value[i] = at[0];
      patch.gradient_x[i] = 0.5F * (at[1] - at[-1]);
      patch.gradient_y[i] = 0.5F * (at[kRim] - at[-kRim]);
    }
  }
  patch.value -= patch.value.mean();
  patch.gradient_x -= patch.gradient_x.mean();
  patch.gradient_y -= patch.gradient_y.mean();
  const float xx = patch.gradient_x.square().sum();
  const float xy = (patch.gradient_x * patch.gradient_y).sum();
  const float yy = patch.gradient_y.square().sum();
  patch.energy = patch.value.square().sum();
  patch.value_gradient_x = (patch.value * patch.gradient_x).sum();
  patch.value_gradient_y = (patch.value * patch.gradient_y).sum();
  const float determinant = xx * yy - xy * xy;
  const float trace = xx + yy;
  // Both eigenvalues must be sizeable: along an edge the patch could slide.
  if (patch.energy < kMinVariance * kArea || determinant < 0.01F * trace * trace) return false;
  patch.inverse_hessian << yy, -xy, -xy, xx;
  patch.inverse_hessian /= determinant;
  return true;
}

/// Grey values of the upright patch around `centre`, mean taken off; false outside the image.
bool samplePatch(const cv::Mat& image, const Eigen::Vector2f& centre, Patch& values) {
  constexpr float kMiddle = 0.5F * (kSize - 1);
  const float left = centre.x() - kMiddle;
  const float top = centre.y() - kMiddle;
  if (!(left >= 0.0F) || !(top >= 0.0F) || !(left + kSize < static_cast<float>(image.cols)) ||
      !(top + kSize < static_cast<float>(image.rows))) {
    return false;
  }
  const int column = static_cast<int>(left);
  const int row = static_cast<int>(top);
  const float fx = left - static_cast<float>(column);
  const float fy = top - static_cast<float>(row);
  const float w00 = (1.0F - fx) * (1.0F - fy);
  const float w01 = fx * (1.0F - fy);
  const float w10 = (1.0F - fx) * fy;
  const float w11 = fx * fy;
  for (int v = 0; v < kSize; ++v) {
    const uchar* upper = image.ptr<uchar>(row + v) + column;
    const uchar* lower = image.ptr<uchar>(row + v + 1) + column;
    float* out = values.data() + v * kSize;
    for (int u = 0; u < kSize; ++u) {
      out[u] = w00 * upper[u] + w01 * upper[u + 1] + w10 * lower[u] + w11 * lower[u + 1];
    }
  }
  values -= values.mean();
  return true;
}

/// The pyramid level whose scale is nearest to `scale`.
int nearestLevel(const ImagePyramid& pyramid, double scale) {
  int best = 0;
  for (int level = 1; level < pyramid.levels(); ++level) {
    if (std::abs(std::log(pyramid.scale(level) / scale)) < std::abs(std::log(pyramid.scale(best) / scale))) {
      best = level;
    }
  }
  return best;
}

}  // namespace

std::optional<PatchMatch> alignPatch(const PatchSource& source, const ImagePyramid& target,
                                     const Eigen::Vector2d& start, const Eigen::Matrix2d& target_from_source,
                                     const AlignmentLimits& limits) {
  const double determinant = target_from_source.determinant();
  if (!(determinant > 0.01) || !(determinant < 100.0)) return std::nullopt;
  const double magnification = std::sqrt(determinant);
  // Measure where a pixel covers what it covered when the feature was found, and sample the source as
  // coarsely.
  const int level = nearestLevel(target, source.pyramid->scale(source.level) * magnification);
  const int source_level = nearestLevel(*source.pyramid, target.scale(level) / magnification);

  Template patch;
  const Eigen::Matrix2d step =
      target_from_source.inverse() * (target.scale(level) / source.pyramid->scale(source_level));
  if (!makeTemplate(source.pyramid->image(source_level), source.pyramid->toLevel(source.raw, source_level),
                    step, patch)) {
    return std::nullopt;
  }

  const cv::Mat& image = target.image(level);
  const Eigen::Vector2f begin = target.toLevel(start, level).cast<float>();
  Eigen::Vector2f at = begin;
  Patch values;
  const auto max_shift = static_cast<float>(limits.max_shift);
  float correlation = -1.0F;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    if (!samplePatch(image, at, values)) return std::nullopt;
    const float product = (values * patch.value).sum();
    const float energy = values.square().sum();
    const float along_x = (patch.gradient_x * values).sum();
    const float along_y = (patch.gradient_y * values).sum();
    if (!(energy > 0.0F)) return std::nullopt;
    correlation = product / std::sqrt(energy * patch.energy);
    if (correlation < 0.2F) return std::nullopt;  // nothing in common: a step from here is a guess
    const float gain = product / patch.energy;
    const Eigen::Vector2f gradient(along_x - gain * patch.value_gradient_x,
                                   along_y - gain * patch.value_gradient_y);
    const Eigen::Vector2f step_back = patch.inverse_hessian * gradient / gain;
    at -= step_back;
    if (!((at - begin).squaredNorm() <= max_shift * max_shift)) return std::nullopt;
    if (step_back.squaredNorm() < kConverged * kConverged) break;
  }
  if (correlation < static_cast<float>(limits.min_correlation)) return std::nullopt;
  return PatchMatch{target.fromLevel(at.cast<double>(), level), level, static_cast<double>(correlation)};
}

}  // namespace ratslam
