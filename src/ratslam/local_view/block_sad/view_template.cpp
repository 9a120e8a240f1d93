#include "ratslam/local_view/block_sad/view_template.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace ratslam {
namespace {

std::string sizeText(int width, int height) { return std::to_string(width) + " x " + std::to_string(height); }

/// The crop along one axis as [min, max), with names for the messages.
struct CropAxis {
  const char* min_key;
  const char* max_key;
  const char* size_key;
  int min;
  int max;
  int size;    // of the template
  int extent;  // of the image
};

/// Checks the crop along one axis and returns its end.
int cropEnd(const CropAxis& axis, const std::string& image_size) {
  if (axis.min >= axis.extent) {
    throwBadValue(axis.min_key, axis.min, "it must lie within the image of " + image_size + " pixels");
  }
  if (axis.max > axis.extent) {
    throwBadValue(axis.max_key, axis.max, "it must not exceed the image of " + image_size + " pixels");
  }
  const int end = axis.max < 0 ? axis.extent : axis.max;
  if (end - axis.min < axis.size) {
    throwBadValue(axis.size_key, axis.size,
                  "the crop is only " + std::to_string(end - axis.min) + " pixels long there (image of " +
                      image_size + " pixels)");
  }
  return end;
}

double meanOf(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// Copies the patch around (x, y) row by row. Values at the edge are repeated.
void copyPatch(const std::vector<double>& values, const TemplateParams& params, int x, int y,
               std::vector<double>& patch) {
  const int radius = params.patch_radius;
  patch.clear();
  for (int dy = -radius; dy <= radius; ++dy) {
    const int row = std::clamp(y + dy, 0, params.y_size - 1);
    const double* row_values = values.data() + static_cast<std::ptrdiff_t>(row) * params.x_size;
    for (int dx = -radius; dx <= radius; ++dx) {
      patch.push_back(row_values[std::clamp(x + dx, 0, params.x_size - 1)]);
    }
  }
}

/// Standard deviation. Exactly 0 for equal values, in spite of the rounding of their mean.
double deviationFrom(double mean, const std::vector<double>& values) {
  const auto [smallest, largest] = std::minmax_element(values.begin(), values.end());
  if (*smallest == *largest) return 0.0;
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  return std::sqrt(squares / static_cast<double>(values.size()));
}

std::vector<double> patchNormalised(const std::vector<double>& values, const TemplateParams& params) {
  std::vector<double> normalised;
  normalised.reserve(values.size());
  std::vector<double> patch;
  for (int y = 0; y < params.y_size; ++y) {
    for (int x = 0; x < params.x_size; ++x) {
      copyPatch(values, params, x, y, patch);
      const double mean = meanOf(patch);
      const double deviation = deviationFrom(mean, patch);
      const double value = values[normalised.size()];
      if (deviation < params.min_patch_std) {
        normalised.push_back(0.5);
      } else if (deviation == 0.0) {
        normalised.push_back(1.0);  // OpenRatSLAM's result of 0 / 0, for which its thresholds were tuned
      } else {
        normalised.push_back(std::clamp(((value - mean) / deviation + 3.0) / 6.0, 0.0, 1.0));
      }
    }
  }
  return normalised;
}

}  // namespace

BlockSums templateBlocks(const cv::Mat& image, const TemplateParams& params) {
  pixelFormat(image);  // so that an unusable image is not reported as a bad crop
  const std::string image_size = sizeText(image.cols, image.rows);
  const CropAxis x{"image_crop_x_min", "image_crop_x_max", "template_x_size", params.crop_x_min,
                   params.crop_x_max,  params.x_size,      image.cols};
  const CropAxis y{"image_crop_y_min", "image_crop_y_max", "template_y_size", params.crop_y_min,
                   params.crop_y_max,  params.y_size,      image.rows};
  const cv::Rect crop(cv::Point(x.min, y.min), cv::Point(cropEnd(x, image_size), cropEnd(y, image_size)));
  return sumBlocks(image, crop, params.x_size, params.y_size);
}

std::vector<double> templateValues(const BlockSums& blocks, double scale, const TemplateParams& params) {
  const double full_scale = static_cast<double>(blocks.full_scale);
  std::vector<double> values(blocks.sums.size());
  std::transform(blocks.sums.begin(), blocks.sums.end(), values.begin(),
                 [&](std::uint64_t sum) { return scaledGrey(sum, full_scale, scale); });
  return params.patch_radius > 0 ? patchNormalised(values, params) : values;
}

std::vector<std::uint8_t> quantised(const std::vector<double>& values) {
  std::vector<std::uint8_t> bytes(values.size());
  std::transform(values.begin(), values.end(), bytes.begin(), [](double value) { return quantised(value); });
  return bytes;
}

double scaleOf(const BlockSums& blocks, const TemplateParams& params) {
  if (params.normalisation <= 0.0) return 1.0;
  const double full_scale = static_cast<double>(blocks.full_scale);
  double sum = 0.0;
  for (const std::uint64_t block : blocks.sums) sum += scaledGrey(block, full_scale, 1.0);
  const double mean = sum / static_cast<double>(blocks.sums.size());
  return mean > 0.0 ? params.normalisation / mean : 1.0;
}

ViewTemplate makeViewTemplate(BlockSums blocks, const TemplateParams& params) {
  const double scale = scaleOf(blocks, params);
  return makeViewTemplate(std::move(blocks), scale, params);
}

ViewTemplate makeViewTemplate(BlockSums blocks, double scale, const TemplateParams& params) {
  ViewTemplate made;
  made.blocks = std::move(blocks);
  made.scale = scale;
  made.values = templateValues(made.blocks, made.scale, params);
  made.mean = meanOf(made.values);
  return made;
}

ViewTemplate makeViewTemplate(const cv::Mat& image, const TemplateParams& params) {
  return makeViewTemplate(templateBlocks(image, params), params);
}

}  // namespace ratslam
