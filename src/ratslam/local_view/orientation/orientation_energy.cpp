#include "ratslam/local_view/orientation/orientation_energy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "ratslam/local_view/block_sad/view_template.h"

namespace ratslam {
namespace {

constexpr double kSemisaturation = 4.0;  // [grey values^2], of the divisive normalisation

std::size_t asSize(int value) { return static_cast<std::size_t>(value); }

/// atan(t) in units of pi/4 for t in [0,1]: error below 1e-5 (Abramowitz and Stegun 4.4.49, scaled).
double eighthTurns(double t) {
  constexpr double kToEighths = 1.2732395447351628;  // 4 / pi
  const double z = t * t;
  return kToEighths * t * (0.9998660 + z * (-0.3302995 + z * (0.1801410 + z * (-0.0851330 + z * 0.0208351))));
}

/// Orientation of a gradient without its sign, as a fraction of half a turn in [0,1].
double orientation(double dx, double dy) {
  const double ax = std::abs(dx);
  const double ay = std::abs(dy);
  const double larger = std::max(ax, ay);
  if (larger == 0.0) return 0.0;
  const double eighths = eighthTurns(std::min(ax, ay) / larger);
  const double in_quarter = ax >= ay ? 0.25 * eighths : 0.5 - 0.25 * eighths;  // from the x axis
  return (dx < 0.0) != (dy < 0.0) ? 1.0 - in_quarter : in_quarter;
}

}  // namespace

OrientationEnergy::OrientationEnergy(const cv::Mat& image, const TemplateParams& crop, bool panoramic)
    : panoramic_(panoramic),
      columns_(asSize(kOrientationCellRows * kOrientationColumns * kOrientationBins), 0.0) {
  TemplateParams grid = crop;
  grid.x_size = kOrientationColumns;
  grid.y_size = kOrientationRows;
  const BlockSums blocks = templateBlocks(image, grid);
  const double to_grey = 255.0 / static_cast<double>(blocks.full_scale);
  std::vector<double> grey(blocks.sums.size());
  std::transform(blocks.sums.begin(), blocks.sums.end(), grey.begin(),
                 [to_grey](std::uint64_t sum) { return static_cast<double>(sum) * to_grey; });
  const auto column = [&](int x) {
    if (panoramic) return (x + kOrientationColumns) % kOrientationColumns;
    return std::clamp(x, 0, kOrientationColumns - 1);
  };
  const auto at = [&](int x, int y) {
    return grey[asSize(std::clamp(y, 0, kOrientationRows - 1) * kOrientationColumns + column(x))];
  };
  for (int y = 0; y < kOrientationRows; ++y) {
    double* bins = columns_.data() + y / kOrientationCell * kOrientationColumns * kOrientationBins;
    for (int x = 0; x < kOrientationColumns; ++x, bins += kOrientationBins) {
      const double dx = at(x + 1, y) - at(x - 1, y);
      const double dy = at(x, y + 1) - at(x, y - 1);
      const double squared = dx * dx + dy * dy;
      contrast_ += squared;
      const double magnitude = std::sqrt(squared);
      const double position = orientation(dx, dy) * kOrientationBins;
      const int lower = std::min(static_cast<int>(position), kOrientationBins - 1);
      const double share = position - lower;
      bins[lower] += magnitude * (1.0 - share);
      bins[(lower + 1) % kOrientationBins] += magnitude * share;
    }
  }
  contrast_ /= kOrientationColumns * kOrientationRows;
}

std::vector<double> OrientationEnergy::values(int shift) const {
  std::vector<double> values(asSize(kOrientationValues), 0.0);
  std::array<double, kOrientationCellRows * kOrientationCellColumns> energy{};  // of cells
  for (int row = 0; row < kOrientationCellRows; ++row) {
    for (int x = 0; x < kOrientationColumns; ++x) {
      const int seen = panoramic_
                           ? (x - shift % kOrientationColumns + kOrientationColumns) % kOrientationColumns
                           : std::clamp(x - shift, 0, kOrientationColumns - 1);
      const double* bins = columns_.data() + (row * kOrientationColumns + seen) * kOrientationBins;
      const int cell = row * kOrientationCellColumns + x / kOrientationCell;
      double* sums = values.data() + cell * kOrientationBins;
      for (int bin = 0; bin < kOrientationBins; ++bin) sums[bin] += bins[bin];
    }
  }
  for (std::size_t cell = 0; cell < energy.size(); ++cell) {
    const double* bins = values.data() + cell * asSize(kOrientationBins);
    for (int bin = 0; bin < kOrientationBins; ++bin) energy[cell] += bins[bin] * bins[bin];
  }
  for (int row = 0; row < kOrientationCellRows; ++row) {
    for (int column = 0; column < kOrientationCellColumns; ++column) {
      double sum = 0.0;
      for (int dy = -1; dy <= 1; ++dy) {
        const int y = std::clamp(row + dy, 0, kOrientationCellRows - 1);
        for (int dx = -1; dx <= 1; ++dx) {
          const int x = panoramic_ ? (column + dx + kOrientationCellColumns) % kOrientationCellColumns
                                   : std::clamp(column + dx, 0, kOrientationCellColumns - 1);
          sum += energy[asSize(y * kOrientationCellColumns + x)];
        }
      }
      const double divisor = std::sqrt(sum / 9.0 + kSemisaturation);
      double* bins = values.data() + (row * kOrientationCellColumns + column) * kOrientationBins;
      for (int bin = 0; bin < kOrientationBins; ++bin) bins[bin] /= divisor;
    }
  }
  return values;
}

}  // namespace ratslam
