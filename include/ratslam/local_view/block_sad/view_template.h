/// Computation of a view template from an image (docs/model.md section 1, steps 1-4):
///
///   1. crop;  2. mean grey of each of X x Y blocks;  3. scaling to a common mean;  4. patch normalisation.
///
/// The values are a function of the block sums (integers) and one scale, to the last bit. So they can be computed again
/// from these when they are needed.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "ratslam/camera/grey.h"
#include "ratslam/local_view/local_view_params.h"

namespace ratslam {

/// X x Y values in [0,1], row by row, and the data from which they were computed.
struct ViewTemplate {
  std::vector<double> values;  ///< value of column x, row y at [y * X + x]
  double mean = 0.0;           ///< of all values
  BlockSums blocks;            ///< of the image
  double scale = 1.0;          ///< factor of step 3
};

/// Steps 1-2. @throws std::invalid_argument for an image that pixelFormat refuses, and naming parameter, value and image
/// size if the crop leaves the image or has fewer pixels than the template has values.
BlockSums templateBlocks(const cv::Mat& image, const TemplateParams& params);

/// Steps 1-4. @throws std::invalid_argument as templateBlocks does.
ViewTemplate makeViewTemplate(const cv::Mat& image, const TemplateParams& params);

/// Steps 3-4 on given block sums.
ViewTemplate makeViewTemplate(BlockSums blocks, const TemplateParams& params);

/// Step 4 on given block sums with a given scale.
ViewTemplate makeViewTemplate(BlockSums blocks, double scale, const TemplateParams& params);

/// The scale of step 3.
double scaleOf(const BlockSums& blocks, const TemplateParams& params);

/// The values of block sums with a given scale.
std::vector<double> templateValues(const BlockSums& blocks, double scale, const TemplateParams& params);

/// The nearest of 256 levels to a value in [0,1]. It differs from 255 times the value by at most half a level, apart
/// from the rounding of this sum. It truncates, because std::lround costs a call.
inline std::uint8_t quantised(double value) { return static_cast<std::uint8_t>(255.0 * value + 0.5); }

/// Values in 8 bits, in the same order.
std::vector<std::uint8_t> quantised(const std::vector<double>& values);

/// Value of one block after step 3.
inline double scaledGrey(std::uint64_t sum, double full_scale, double scale) {
  const double value = static_cast<double>(sum) / full_scale * scale;
  return value < 1.0 ? value : 1.0;
}

}  // namespace ratslam
