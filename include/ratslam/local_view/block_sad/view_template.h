/// How an image becomes a view template (docs/model.md section 1, steps 1-4):
///
///   1. crop;  2. mean grey of each of X x Y blocks;  3. scaling to a common mean;  4. patch normalisation.
///
/// The arithmetic is fixed to the last bit: a template's values are a function of its block sums (integers)
/// and one scale, so that they can be computed again from these whenever they are needed.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ratslam/camera/grey.h"
#include "ratslam/local_view/local_view_params.h"

namespace ratslam {

/// X x Y values in [0,1], row by row, and what they were computed from.
struct ViewTemplate {
  std::vector<double> values;  ///< value of column x, row y at [y * X + x]
  double mean = 0.0;           ///< of all values
  BlockSums blocks;            ///< of the image
  double scale = 1.0;          ///< factor of step 3
};

/// Steps 1-2. @throws std::invalid_argument for an image that pixelFormat refuses; where the crop leaves the
/// image or holds fewer pixels than the template has values: naming parameter, value and image size.
BlockSums templateBlocks(const cv::Mat& image, const TemplateParams& params);

/// Steps 1-4. @throws std::invalid_argument as templateBlocks does.
ViewTemplate makeViewTemplate(const cv::Mat& image, const TemplateParams& params);

/// Steps 3-4 on given block sums.
ViewTemplate makeViewTemplate(BlockSums blocks, const TemplateParams& params);

/// The values that these block sums give with this scale.
std::vector<double> templateValues(const BlockSums& blocks, double scale, const TemplateParams& params);

/// The nearest of 256 levels to a value in [0,1]: half a level from 255 times the value at most, but for the
/// rounding of this sum. Truncation, because std::lround costs a call.
inline std::uint8_t quantised(double value) { return static_cast<std::uint8_t>(255.0 * value + 0.5); }

/// Values in 8 bits, in the same order.
std::vector<std::uint8_t> quantised(const std::vector<double>& values);

/// Value of one block after step 3.
inline double scaledGrey(std::uint64_t sum, double full_scale, double scale) {
  const double value = static_cast<double>(sum) / full_scale * scale;
  return value < 1.0 ? value : 1.0;
}

}  // namespace ratslam
