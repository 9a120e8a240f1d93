/// Orientation energies of an image, modelled on the complex cells of V1: the strength of edges of each orientation in
/// each part of the view, independent of the light.
///
///   1. Grey, 64 x 32 pixels: block means of the crop. Gradients by [-1 0 1] in x and y.
///   2. The orientation of each gradient, without its sign, is shared linearly between the 2 nearest of 9
///      bins, weighted by its magnitude, and summed over cells of 4 x 4 pixels: 16 x 8 x 9 values.
///   3. Divisive normalisation: each value is divided by sqrt(m + 4), m being the mean over the 3 x 3 cells
///      around it of the summed squares of their bins (in grey values of 0 to 255).
///
/// The arithmetic is fixed, so that every machine gives the same bits: sums in one order, a polynomial for the angle,
/// and of library functions only the square root.
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
  /// Steps 1 and 2 without the sums over cells. @param panoramic the last column adjoins the first.
  /// @throws std::invalid_argument as templateBlocks does.
  OrientationEnergy(const cv::Mat& image, const TemplateParams& crop, bool panoramic);

  /// The sums of step 2, and step 3, with the image moved by `shift` pixels to the right. For a forward camera the
  /// edge is repeated.
  /// @return kOrientationValues, by row of cells, column of cells, bin.
  std::vector<double> values(int shift) const;

  /// Mean squared gradient [grey values^2].
  double contrast() const { return contrast_; }

 private:
  bool panoramic_;
  double contrast_ = 0.0;
  std::vector<double> columns_;  // the bins of each row of cells and column of pixels
};

}  // namespace ratslam
