/// Orientation energies of an image, after the complex cells of V1: how much edge of each orientation there is
/// in each part of the view, whatever the light.
///
///   1. Grey, 64 x 32 pixels: block means of the crop. Gradients by [-1 0 1] in x and y.
///   2. The orientation of each gradient, without its sign, is shared linearly between the 2 nearest of 9
///      bins, weighted by its magnitude, and summed over cells of 4 x 4 pixels: 16 x 8 x 9 values.
///   3. Divisive normalisation: each value is divided by sqrt(m + 4), m being the mean over the 3 x 3 cells
///      around it of the summed squares of their bins (in grey values of 0 to 255).
///
/// The arithmetic is fixed: sums in one order, a polynomial for the angle, no function of a library but the
/// square root, so that every machine has the same bits.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "ratslam/local_view/local_view_params.h"

namespace ratslam {

constexpr int kOrientationColumns = 64;  ///< pixels
constexpr int kOrientationRows = 32;
constexpr int kOrientationCell = 4;  ///< side of a cell [pixels]
constexpr int kOrientationCellColumns = kOrientationColumns / kOrientationCell;
constexpr int kOrientationCellRows = kOrientationRows / kOrientationCell;
constexpr int kOrientationBins = 9;
constexpr int kOrientationValues = kOrientationCellColumns * kOrientationCellRows * kOrientationBins;

class OrientationEnergy {
 public:
  /// Steps 1 and 2, but for the sums. @param panoramic the columns close into a circle.
  /// @throws std::invalid_argument as templateBlocks does.
  OrientationEnergy(const cv::Mat& image, const TemplateParams& crop, bool panoramic);

  /// Steps 2 and 3 with the image moved by `shift` pixels to the right; what comes in at the edge of a
  /// forward camera's image repeats the edge.
  /// @return kOrientationValues, by row of cells, column of cells, bin.
  std::vector<double> values(int shift) const;

  /// Mean squared gradient [grey values^2].
  double contrast() const { return contrast_; }

 private:
  bool panoramic_;
  double contrast_ = 0.0;
  std::vector<double> columns_;  // of each row of cells and each column of pixels, its bins
};

}  // namespace ratslam
