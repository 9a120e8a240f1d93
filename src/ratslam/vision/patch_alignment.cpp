#include "ratslam/vision/patch_alignment.h"

#include <Eigen/LU>
#include <cmath>

#include "ratslam/simd/patch_kernels.h"

namespace ratslam {
namespace {

constexpr int kMaxIterations = 10;
constexpr float kConverged = 0.01F;  // [px of the level]
// Least variance of the template's grey values: below it there is only noise to align.
constexpr float kMinVariance = 9.0F;
const Eigen::Vector2d kPatchMiddle(0.5 * (kPatchColumns - 1), 0.5 * (kPatchRows - 1));

const PatchKernels& kernels = patchKernels();

struct Template {
  PatchTemplate patch;
  TemplateSums sums;
  Eigen::Matrix2f inverse_hessian;
};

/// Samples the source image as it should appear at the target level. @param step source-level pixels per
/// target-level pixel.
bool makeTemplate(const cv::Mat& image, const Eigen::Vector2d& centre, const Eigen::Matrix2d& step,
                  Template& made) {
  const Eigen::Vector2d middle = kPatchMiddle + Eigen::Vector2d::Ones();  // of the rim
  constexpr double kRounding = 2e-3;                                      // of positions as floats [px]
  const Eigen::Vector2d reach = step.cwiseAbs() * middle + kRounding * Eigen::Vector2d::Ones();
  if (!((centre - reach).minCoeff() >= 0.0) || !(centre.x() + reach.x() < image.cols - 1) ||
      !(centre.y() + reach.y() < image.rows - 1)) {
    return false;
  }
  const Eigen::Vector2f origin = (centre - step * middle).cast<float>();
  const Eigen::Matrix<float, 2, 2, Eigen::RowMajor> m = step.cast<float>();
  float rim[kRimStorage];
  kernels.sampleRim(image.data, static_cast<std::ptrdiff_t>(image.step), origin.data(), m.data(), rim);
  made.sums = kernels.fillTemplate(rim, made.patch);
  const TemplateSums& sums = made.sums;
  const float determinant = sums.x_x * sums.y_y - sums.x_y * sums.x_y;
  const float trace = sums.x_x + sums.y_y;
  // Both eigenvalues must be large enough, because a patch could slide along an edge.
  if (sums.value_value < kMinVariance * kPatchArea || determinant < 0.01F * trace * trace) return false;
  made.inverse_hessian << sums.y_y, -sums.x_y, -sums.x_y, sums.x_x;
  made.inverse_hessian /= determinant;
  return true;
}

/// Compares the upright patch around `centre` with the template. @return false outside the image.
bool comparePatch(const cv::Mat& image, const Eigen::Vector2f& centre, const PatchTemplate& patch,
                  PatchSums& sums) {
  const Eigen::Vector2f corner = centre - kPatchMiddle.cast<float>();
  if (!(corner.x() >= 0.0F) || !(corner.y() >= 0.0F) ||
      !(corner.x() + kPatchColumns < static_cast<float>(image.cols)) ||
      !(corner.y() + kPatchRows < static_cast<float>(image.rows))) {
    return false;
  }
  const int column = static_cast<int>(corner.x());
  const int row = static_cast<int>(corner.y());
  sums =
      kernels.compare(image.ptr<uchar>(row) + column, static_cast<std::ptrdiff_t>(image.step),
                      corner.x() - static_cast<float>(column), corner.y() - static_cast<float>(row), patch);
  return true;
}

/// Prefetches the patch's pixels, because the rows of an image are far apart in memory.
void prefetchPatch(const cv::Mat& image, const Eigen::Vector2f& centre) {
  const Eigen::Vector2f corner = centre - kPatchMiddle.cast<float>();
  if (!(corner.x() >= 0.0F) || !(corner.y() >= 0.0F) || !(corner.x() < static_cast<float>(image.cols)) ||
      !(corner.y() + kPatchRows < static_cast<float>(image.rows))) {
    return;
  }
  const int column = static_cast<int>(corner.x());
  const int first = static_cast<int>(corner.y());
  for (int row = first; row <= first + kPatchRows; ++row) {
    __builtin_prefetch(image.ptr<uchar>(row) + column);
  }
}

/// The pyramid level with the scale nearest to `scale` by ratio.
int nearestLevel(const ImagePyramid& pyramid, double scale) {
  int level = 0;
  while (level + 1 < pyramid.levels() && scale * scale > pyramid.scale(level) * pyramid.scale(level + 1))
    ++level;
  return level;
}

}  // namespace

std::optional<PatchMatch> alignPatch(const PatchSource& source, const ImagePyramid& target,
                                     const Eigen::Vector2d& start, const Eigen::Matrix2d& target_from_source,
                                     const AlignmentLimits& limits) {
  const double determinant = target_from_source.determinant();
  if (!(determinant > 0.01) || !(determinant < 100.0)) return std::nullopt;
  const double magnification = std::sqrt(determinant);
  // Measure at the target level where a pixel covers the same area as at the feature's level, and sample the source
  // at the corresponding level.
  const int level = nearestLevel(target, source.pyramid->scale(source.level) * magnification);
  const int source_level = nearestLevel(*source.pyramid, target.scale(level) / magnification);

  const cv::Mat& image = target.image(level);
  const Eigen::Vector2f begin = target.toLevel(start, level).cast<float>();
  prefetchPatch(image, begin);

  Template model;
  const Eigen::Matrix2d step =
      target_from_source.inverse() * (target.scale(level) / source.pyramid->scale(source_level));
  if (!makeTemplate(source.pyramid->image(source_level), source.pyramid->toLevel(source.raw, source_level),
                    step, model)) {
    return std::nullopt;
  }

  Eigen::Vector2f at = begin;
  const auto max_shift = static_cast<float>(limits.max_shift);
  float correlation = -1.0F;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    PatchSums sums;
    if (!comparePatch(image, at, model.patch, sums)) return std::nullopt;
    const float energy = sums.square - sums.value * sums.value / static_cast<float>(kPatchArea);
    if (!(energy > 0.0F)) return std::nullopt;
    correlation = sums.product / std::sqrt(energy * model.sums.value_value);
    if (correlation < 0.2F) return std::nullopt;  // the patches are unrelated, so a step would be random
    const float gain = sums.product / model.sums.value_value;
    const Eigen::Vector2f gradient(sums.along_x - gain * model.sums.value_x,
                                   sums.along_y - gain * model.sums.value_y);
    const Eigen::Vector2f step_back = model.inverse_hessian * gradient / gain;
    at -= step_back;
    if (!((at - begin).squaredNorm() <= max_shift * max_shift)) return std::nullopt;
    if (step_back.squaredNorm() < kConverged * kConverged) break;
  }
  if (correlation < static_cast<float>(limits.min_correlation)) return std::nullopt;
  return PatchMatch{target.fromLevel(at.cast<double>(), level), level, static_cast<double>(correlation)};
}

}  // namespace ratslam
