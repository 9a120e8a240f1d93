/// Attractor dynamics of the pose cells, eqs. (1) and (2): one iteration of
///  1. local excitation   P <- P (*) E
///  2. local inhibition   P <- P - P (*) I
///  3. global inhibition  P <- max(0, P - phi)
///  4. normalisation      P <- P / sum(P)
/// with (*) circular convolution and E, I truncated Gaussians that sum to 1.
#pragma once

#include <vector>

#include "ratslam/pose_cells/activity_grid.h"
#include "ratslam/pose_cells/params.h"

namespace ratslam {

class Attractor {
 public:
  explicit Attractor(const PoseCellParams& params);

  /// One iteration. @param model_sum what the model's activity sums to: the grid's is scaled to 1.
  /// @return false if no activity was left: the grid is empty then.
  bool iterate(ActivityGrid& grid, double model_sum);

 private:
  ActivityGrid convolve(const ActivityGrid& in, const std::vector<double>& xy,
                        const std::vector<double>& th) const;

  double global_inhibition_;
  std::vector<double> excitation_xy_, excitation_th_, inhibition_xy_, inhibition_th_;
};

}  // namespace ratslam
